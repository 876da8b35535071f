"""A workbench that is served in this process, and who asks it."""

import http.client
import json
import socket
import threading
from contextlib import contextmanager
from urllib.parse import quote, urlsplit

from vasowave.workbench import Workbench, server_of


class Asker:
    """A page's questions, without a page."""

    def __init__(self, address, guard, workbench):
        self.address, self.guard, self.workbench = address, guard, workbench
        parts = urlsplit(address)
        self.port, self.root = parts.port, parts.path
        self.of_report = f"/{guard.report_token}/" if guard else ""
        self.origin = f"http://127.0.0.1:{self.port}"

    def raw(self, method, path, body=None, **headers):
        """Return status, headers and body; `headers` with _ for -, None leaves one out."""
        given = {"Host": f"127.0.0.1:{self.port}"} | ({"Origin": self.origin} if method != "GET" else {})
        given |= {name.replace("_", "-"): value for name, value in headers.items()}
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=600)
        connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        for name, value in given.items():
            for one in value if isinstance(value, list) else [value]:
                if one is not None:
                    connection.putheader(name, one)
        if body is not None and "Content-Length" not in given and "Transfer-Encoding" not in given:
            connection.putheader("Content-Length", str(len(body)))
        connection.endheaders()
        if body is not None:
            connection.send(body)
        reply = connection.getresponse()
        content = reply.read()
        connection.close()
        return reply.status, {name.lower(): value for name, value in reply.getheaders()}, content

    def get(self, what, **given):
        query = "&".join(f"{name}={quote(str(value), safe='')}" for name, value in given.items())
        status, _, content = self.raw("GET", f"{self.root}{what}?{query}")
        assert status == 200, content
        return json.loads(content)

    def post(self, what, message):
        status, _, content = self.raw("POST", self.root + what, json.dumps(message).encode())
        return status, json.loads(content)

    def act(self, what, **given):
        status, answer = self.post("act", {"do": what, **given})
        assert status == 200, answer
        return answer["said"]

    def put(self, name, content):
        status, _, answer = self.raw("PUT", f"{self.root}upload?name={quote(name, safe='')}", content)
        return status, json.loads(answer)


@contextmanager
def served(folder):
    workbench, found, ready = Workbench(folder), [], threading.Event()
    with socket.socket() as door:
        door.bind(("127.0.0.1", 0))
        server = server_of(workbench, door, lambda *opened: (found.extend(opened), ready.set()))
        thread = threading.Thread(target=server.run, kwargs={"sockets": [door]}, daemon=True)
        thread.start()
        assert ready.wait(30)
        try:
            yield Asker(*found, workbench)
        finally:
            server.should_exit = True
            thread.join(20)
            assert not thread.is_alive()
