"""``bag view``: a bag on the page, in a domain of its own."""

from __future__ import annotations

import re
import urllib.request

from tests.bag.bags import write_bag


def test_the_page_of_a_bag_is_there_and_what_is_played_stays_in_its_domain(ros):
    write_bag(ros.folder / "bag", count=3000)
    process = ros.spawn("bag view bag --port 0")
    found = process.wait_for_line(r"^The bag in your browser: (http://localhost:\d+/)$")
    domain = process.wait_for_line(r"^Its topics: ROS_DOMAIN_ID=(\d+) ")[1]
    with urllib.request.urlopen(found[1]) as page:
        assert b"<html" in page.read()
    assert "/topic_0" not in ros.run("topic list").stdout
    ros.env["ROS_DOMAIN_ID"] = domain
    received = ros.run("topic echo --once /topic_0 --field data")
    assert re.match(r"/topic_0 \d+", received.stdout)
    process.interrupt()
    assert process.wait() == 0
    assert "Traceback" not in process.stderr


def test_what_cannot_be_shown_is_told_at_once(ros):
    done = ros.run("bag view nothing")
    assert (done.returncode, done.stdout) == (1, "")
    assert "does not exist" in done.stderr
    write_bag(ros.folder / "bag")
    done = ros.run("bag view bag --rate 0")
    assert done.returncode == 2
    (ros.folder / "token").write_text("secret", encoding="utf-8")
    (ros.folder / "token").chmod(0o644)
    done = ros.run("bag view bag --host 0.0.0.0 --token-file token")
    assert (done.returncode, done.stdout) == (1, "")
    assert "Others can read" in done.stderr
