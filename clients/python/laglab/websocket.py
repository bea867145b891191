"""The client's side of RFC 6455, as far as laglab's streams need it: text messages, pings, a close. The standard
library has none, and a package that needs none can be copied into any course."""

from __future__ import annotations

import base64
import hashlib
import os
import socket
import ssl
import struct
from urllib.parse import urlsplit

from .errors import LaglabError

_GUID = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
_TEXT, _CLOSE, _PING, _PONG = 1, 8, 9, 10
_MESSAGE_MAX = 64 << 20


class WebSocket:
    """One connection. Not for several threads at a time."""

    def __init__(self, url: str, subprotocol: str, timeout_s: float) -> None:
        parts = urlsplit(url)
        secure = parts.scheme == "https"
        host, port = parts.hostname or "", parts.port or (443 if secure else 80)
        plain = socket.create_connection((host, port), timeout_s)
        self._socket = ssl.create_default_context().wrap_socket(plain, server_hostname=host) if secure else plain
        self._read = self._socket.makefile("rb")
        self.close_code: int | None = None
        self.close_reason = ""
        try:
            self._shake_hands(parts.netloc.rpartition("@")[2], parts.path, subprotocol)
        except BaseException:
            self._end()
            raise

    def _shake_hands(self, host: str, path: str, subprotocol: str) -> None:
        key = base64.b64encode(os.urandom(16)).decode()
        request = (
            f"GET {path} HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: {subprotocol}\r\n\r\n"
        )
        self._socket.sendall(request.encode())
        status = self._read.readline(8192).decode("latin-1").split(" ", 2)
        fields: dict[str, str] = {}
        while (line := self._read.readline(8192).decode("latin-1").strip()) != "":
            name, _, value = line.partition(":")
            fields[name.lower()] = value.strip()
        if len(status) < 2 or status[1] != "101":
            code = int(status[1]) if len(status) > 1 and status[1].isdecimal() else None
            raise LaglabError(f"no stream: the daemon answers {' '.join(status).strip()}", status=code)
        expected = base64.b64encode(hashlib.sha1((key + _GUID).encode()).digest()).decode()
        if fields.get("sec-websocket-accept") != expected:
            raise LaglabError("no stream: the answer to the upgrade is not a WebSocket's")

    def _send(self, opcode: int, payload: bytes) -> None:
        size = len(payload)
        head = bytes([0x80 | opcode])
        if size < 126:
            head += bytes([0x80 | size])
        elif size < 1 << 16:
            head += struct.pack("!BH", 0x80 | 126, size)
        else:
            head += struct.pack("!BQ", 0x80 | 127, size)
        mask = os.urandom(4)
        masked = bytes(byte ^ mask[i & 3] for i, byte in enumerate(payload))
        self._socket.sendall(head + mask + masked)

    def send(self, text: str) -> None:
        self._send(_TEXT, text.encode())

    def _exactly(self, count: int) -> bytes:
        got = self._read.read(count)
        if got is None or len(got) < count:
            raise ConnectionError("the daemon has ended the connection")
        return got

    def _frame(self) -> tuple[bool, int, bytes]:
        first, second = self._exactly(2)
        size = second & 127
        if size == 126:
            (size,) = struct.unpack("!H", self._exactly(2))
        elif size == 127:
            (size,) = struct.unpack("!Q", self._exactly(8))
        if second & 128 or first & 0x70 or size > _MESSAGE_MAX:
            raise LaglabError("the stream has a frame that RFC 6455 does not allow a server, or one too large")
        return bool(first & 128), first & 15, self._exactly(size)

    def receive(self) -> str | None:
        """The next message; None when the daemon has closed: `close_code` and `close_reason` say why."""
        message = b""
        while True:
            final, opcode, payload = self._frame()
            if opcode == _PING:
                self._send(_PONG, payload)
            elif opcode == _CLOSE:
                self.close_code = struct.unpack("!H", payload[:2])[0] if len(payload) >= 2 else 1005
                self.close_reason = payload[2:].decode("utf-8", "replace")
                self._send(_CLOSE, payload[:2])
                self._end()
                return None
            elif opcode != _PONG:
                message += payload
                if final:
                    return message.decode()

    def _end(self) -> None:
        self._read.close()
        self._socket.close()

    def close(self) -> None:
        """Says goodbye and closes. May be called again."""
        if self._read.closed:
            return
        try:
            self._send(_CLOSE, struct.pack("!H", 1000))
        except OSError:
            pass
        self._end()
