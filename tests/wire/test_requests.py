"""A request of somebody who has no node, to a real server."""

import pytest

from teleopctl.errors import UnavailableError
from teleopctl.interfaces import get_service, type_hash
from teleopctl.testing import eventually
from teleopctl.wire import ServiceRequest, encode_attachment, open_session, query_graph, topic_key

TRIGGER = get_service("std_srvs/srv/Trigger")


@pytest.fixture(scope="module")
def session(shared_ros):
    with open_session("client") as session:
        yield session


def asked(session, service):
    return ServiceRequest(session, TRIGGER, service, TRIGGER.Request())


@pytest.fixture
def serve_bytes(shared_ros, session):
    """Serve Trigger by a function that is given each query."""
    channels = []

    def serve(service, answer):
        key = topic_key(shared_ros.domain, service, TRIGGER.TYPE_NAME, type_hash(TRIGGER.TYPE_NAME))
        # In the session that asks, which knows of it at once.
        channels.append(
            session.declare_queryable(key, lambda query: answer(query, key), complete=True)
        )

    yield serve
    for channel in channels:
        channel.undeclare()


def test_a_question_is_answered_and_leaves_no_client_in_the_graph(shared_ros, session):
    clients = []

    def answer(_, response):
        clients.extend(shared_ros.node.graph().clients("/calibrate"))
        response.message = "done"
        return response

    server = shared_ros.node.create_service(TRIGGER, "/calibrate", answer, immediate=True)
    eventually(lambda: query_graph(session).servers("/calibrate"), what="the server")
    question = asked(session, "/calibrate")
    response = question.wait_for_response(20)
    assert response is not None
    assert (response.message, clients) == ("done", [])
    assert question.wait_for_response(0.0) is response
    server.destroy()


def test_questions_of_one_session_are_told_apart_by_servers(session, serve_bytes):
    kept = []
    serve_bytes("/patient", lambda query, _: kept.append(query.attachment.to_bytes()[-16:]))
    for _ in range(2):
        # A query that is let go of unanswered ends the wait.
        with pytest.raises(UnavailableError, match="no server"):
            asked(session, "/patient").wait_for_response(20)
    assert len(set(kept)) == 2


def test_a_service_that_nobody_serves_does_not_answer(session):
    with pytest.raises(UnavailableError, match="service '/nobody' did not answer: no server"):
        asked(session, "/nobody").wait_for_response(20)


def test_an_answer_that_is_none_is_named(session, serve_bytes):
    def confuse(query, key):
        query.reply(key, b"\0\1\0\0\1", attachment=encode_attachment(7, 0, bytes(16)))

    serve_bytes("/confused", confuse)
    with pytest.raises(UnavailableError, match=r"its answer was dropped: .*with another's"):
        asked(session, "/confused").wait_for_response(20)


def test_a_wait_ends_with_its_time(session, serve_bytes):
    kept = []
    serve_bytes("/hanging", lambda query, _: kept.append(query))
    question = asked(session, "/hanging")
    assert question.wait_for_response(0.0) is None
    assert not question.wait_until_settled(0.0)
