# SPDX-License-Identifier: Apache-2.0
"""A browser as far as --page needs one: reads the page and the events that follow it. Python's standard library alone."""
import http.client
import json
import socket
import threading
import time


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def get(port, path, method="GET", seconds=20.0, **headers):
    """Status, headers and content, once somebody listens."""
    end = time.monotonic() + seconds
    while True:
        try:
            connection = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
            connection.request(method, path, headers=headers)
            response = connection.getresponse()
            return response.status, dict(response.getheaders()), response.read().decode()
        except ConnectionRefusedError:
            if time.monotonic() > end:
                raise
            time.sleep(0.01)


def connected(port, path="/events", seconds=20.0, buffer_bytes=None):
    """A socket that has asked for the events, and has read nothing."""
    end = time.monotonic() + seconds
    while True:
        one = socket.socket()
        if buffer_bytes:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer_bytes)
        try:
            one.connect(("127.0.0.1", port))
            one.sendall(f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode())
            return one
        except ConnectionRefusedError:
            one.close()
            if time.monotonic() > end:
                raise
            time.sleep(0.01)


def events(port, until="end", seconds=60.0, last_id=None):
    """[(event, data, id), ...] up to one of the name `until`, or to the end of the stream."""
    headers = {"Last-Event-ID": last_id} if last_id else {}
    end = time.monotonic() + seconds
    found = []
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=seconds)
    connection.request("GET", "/events", headers=headers)
    response = connection.getresponse()
    assert response.status == 200 and response.getheader("Content-Type") == "text/event-stream", response.status
    fields = {}
    while time.monotonic() < end and (line := response.readline()):
        line = line.decode().rstrip("\n")
        if line:
            key, _, value = line.partition(": ")
            fields[key] = value
        elif "event" in fields:
            found.append((fields["event"], json.loads(fields["data"]), fields["id"]))
            if fields["event"] == until:
                break
            fields = {}
    connection.close()
    return found


class Follower(threading.Thread):
    """Reads page and events while the program runs."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.port, self.page, self.events, self.wrong = port, None, [], None
        self.start()

    def run(self):
        try:
            self.page = get(self.port, "/")
            self.events = events(self.port, seconds=600)
        except Exception as error:  # said by the check that misses what it would have read
            self.wrong = error

    def of(self, name):
        return [data for event, data, _ in self.events if event == name]
