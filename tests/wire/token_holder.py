"""Process with the token of a node until its stdin closes: ``token_holder DOMAIN NODE``."""

import sys

from teleopctl.wire.session import open_session
from teleopctl.wire.tokens import NodeToken, format_token

with open_session("peer") as session:
    token = NodeToken(int(sys.argv[1]), str(session.zid()), 0, "/", "/", sys.argv[2])
    held = session.liveliness().declare_token(format_token(token))
    print("declared", flush=True)
    sys.stdin.read()
