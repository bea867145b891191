"""Runs the cases of Autobahn|Testsuite against a live stream of the daemon, one JSON object a line.

    python3 driver.py --testsuite DIR --port N --path PATH [--bytewise] [--only 2.10,7] [--slack 3] [--at-once 8]

The suite is of Python 2. Its case classes, which say what is sent, what is expected and how it is judged, are loaded from DIR as
they are; this file stands for what they were written against: the client of autobahn 0.10 and its timers. Octets are characters of
Latin-1 here as they were in Python 2.

The daemon does not echo: it answers each text message by one text message (these are no JSON, so by an error). An answer counts as the
echo of the oldest text message without one. So the number of messages, their order among pongs and closes are checked, not their text.
Binary messages of the daemon are its frames, and not counted; a case begins when the daemon's ping behind the first of them is answered. --bytewise sends every byte by a write of its own;
--slack N waits N times as long as the suite."""
import argparse
import ast
import asyncio
import base64
import binascii
import builtins
import codecs
import glob
import json
import os
import re
import socket
import struct
import sys
import types

CLOSE_TIMEOUT_S = 1  # of autobahn: for the answer to a close frame, and for the server to end the connection
OPEN_TIMEOUT_S = 10
CHAPTERS = (1, 2, 3, 4, 5, 6, 7, 9, 10)


# ---- the suite ----


class Utf8Validator:
    def __init__(self):
        self.reset()

    def reset(self):
        self.decoder = codecs.getincrementaldecoder("utf-8")()

    def validate(self, octets):
        """Valid so far, and ends between two characters."""
        try:
            self.decoder.decode(octets.encode("latin-1"))
        except UnicodeDecodeError:
            return False, False
        return True, self.decoder.getstate()[0] == b""


class WebSocketProtocol:
    STATE_CLOSED, STATE_CONNECTING, STATE_CLOSING, STATE_OPEN = range(4)
    MESSAGE_TYPE_TEXT, MESSAGE_TYPE_BINARY = 1, 2
    CLOSE_STATUS_CODE_NORMAL = 1000
    CLOSE_STATUS_CODE_GOING_AWAY = 1001
    CLOSE_STATUS_CODE_PROTOCOL_ERROR = 1002
    CLOSE_STATUS_CODE_INVALID_PAYLOAD = 1007


class Python3(ast.NodeTransformer):
    """Division of whole numbers is whole, and a class has no `object` before its base."""

    def visit_Div(self, node):
        return ast.FloorDiv()

    def visit_Tuple(self, node):
        self.generic_visit(node)
        if len(node.elts) == 2 and isinstance(node.elts[0], ast.Name) and node.elts[0].id == "object":
            node.elts = node.elts[1:]
        return node


class Suite:
    """The modules of autobahntestsuite/case, which import each other by their plain names."""

    def __init__(self, folder):
        self.folder = os.path.join(folder, "autobahntestsuite", "autobahntestsuite", "case")
        if not os.path.exists(os.path.join(self.folder, "case.py")):
            sys.exit(f"driver: {folder} is no checkout of crossbario/autobahn-testsuite: it has no autobahntestsuite/autobahntestsuite/case")
        octets = lambda text: binascii.b2a_hex(text.encode("latin-1")).decode()
        self.modules = {
            "autobahn.websocket.protocol": types.SimpleNamespace(WebSocketProtocol=WebSocketProtocol),
            "autobahn.websocket.utf8validator": types.SimpleNamespace(Utf8Validator=Utf8Validator),
            "binascii": types.SimpleNamespace(b2a_hex=octets),
        }

    def load(self, name, *_args):
        if name not in self.modules:
            file = os.path.join(self.folder, f"{name}.py")
            if not os.path.exists(file):
                return builtins.__import__(name)
            with open(file, encoding="latin-1", newline="") as source:
                text = source.read().replace("\r\n", "\n")
            text = re.sub(r"^(\s*)print( .*)?$", r"\1pass", text, flags=re.M)  # of its own tests
            module = types.ModuleType(name)
            module.__dict__["__builtins__"] = {**vars(builtins), "__import__": self.load, "xrange": range, "unichr": chr}
            self.modules[name] = module
            exec(compile(ast.fix_missing_locations(Python3().visit(ast.parse(text))), file, "exec"), module.__dict__)
        return self.modules[name]

    def cases(self):
        """[(id, class)] in their order; without 9.9.1, which the suite itself leaves out."""
        found = {}
        for file in glob.glob(os.path.join(self.folder, "case*_*.py")):
            name = os.path.basename(file)[:-3]
            if int(re.match(r"case(\d+)", name)[1]) not in CHAPTERS or name == "case9_9_1":
                continue
            for value in vars(self.load(name)).values():
                for each in value if isinstance(value, list) else [value]:
                    if isinstance(each, type) and (match := re.fullmatch(r"Case(\d+(?:_\d+)+)", each.__name__)):
                        found[tuple(map(int, match[1].split("_")))] = each
        base = self.modules["case"].Case
        base.compare = lambda self, one, other: one == other  # pickles of equal strings differ
        return [(".".join(map(str, key)), found[key]) for key in sorted(found)]


# ---- the client ----


class Client(WebSocketProtocol):
    """What the cases call `self.p`."""

    def __init__(self, bytewise, slack):
        self.factory = types.SimpleNamespace(isServer=False)
        self.bytewise = bytewise
        self.slack = slack
        self.state = self.STATE_CONNECTING
        self.connectionWasOpen = self.closedByMe = self.failedByMe = self.droppedByMe = self.wasClean = False
        self.remoteCloseCode = self.localCloseReason = None
        self.remoteCloseReason = ""
        self.createWirelog = True
        self.autoFragmentSize = 0
        self.txFrameStats = {}
        self.late = ""  # what took longer than the suite waits
        self.case = None
        self.unanswered = []  # text messages, of which the oldest is echoed next
        self.sending = None  # the text message that is being sent in pieces
        self.queue = asyncio.Queue()
        self.input = bytearray()
        self.timers = []
        self.answers = 0
        self.pinged = self.begun = False

    # -- what cases ask for --

    def enableWirelog(self, on):
        self.createWirelog = on

    def after(self, delay, what, *args):
        self.timers.append(asyncio.get_running_loop().call_later(delay * self.slack, what, *args))

    def if_open(self, what, *args):
        if self.state != self.STATE_CLOSED:
            what(*args)

    def continueLater(self, delay, what, tag=None):
        self.after(delay, self.if_open, what)

    def killAfter(self, delay):
        self.after(delay, self.if_open, self.fail)

    def closeAfter(self, delay):
        self.after(delay, self.if_open, self.sendClose)

    def fail(self):
        self.failedByMe = True
        if self.state == self.STATE_OPEN:
            self.sendClose(self.CLOSE_STATUS_CODE_GOING_AWAY)
        else:
            self.drop("")

    def send(self, octets, size=None):
        """`octets` in writes of `size`."""
        size = 1 if self.bytewise else size
        for at in range(0, len(octets), size) if size else [0]:
            self.queue.put_nowait(octets[at : at + size] if size else octets)

    def head(self, opcode, fin, rsv, size, key):
        first = (0x80 if fin else 0) | rsv << 4 | opcode
        if size < 126:
            return bytes([first, 0x80 | size]) + key
        if size < 65536:
            return bytes([first, 0x80 | 126]) + struct.pack("!H", size) + key
        return bytes([first, 0x80 | 127]) + struct.pack("!Q", size) + key

    def mask(self, key, octets, at=0):
        keys = (key * 2)[at % 4 : at % 4 + 4]
        whole = keys * (len(octets) // 4 + 1)
        return (int.from_bytes(octets, "big") ^ int.from_bytes(whole[: len(octets)], "big")).to_bytes(len(octets), "big")

    def sendFrame(self, opcode, payload="", fin=True, rsv=0, mask=None, payload_len=None, chopsize=None, sync=False):
        if payload_len is not None:
            payload = (payload * (payload_len // max(len(payload), 1) + 1))[:payload_len]
        self.txFrameStats[opcode] = self.txFrameStats.get(opcode, 0) + 1
        if opcode == 1:
            self.sending = [payload]
        elif opcode == 0 and self.sending is not None:
            self.sending.append(payload)
        if opcode < 2 and fin and self.sending is not None:
            self.unanswered.append("".join(self.sending))
            self.sending = None
        key = os.urandom(4)
        octets = payload.encode("latin-1")
        self.send(self.head(opcode, fin, rsv, len(octets), key) + self.mask(key, octets), chopsize)

    def sendMessage(self, payload, isBinary=False, fragmentSize=None, sync=False):
        size = fragmentSize or self.autoFragmentSize or max(len(payload), 1)
        parts = [payload[at : at + size] for at in range(0, len(payload), size)] or [""]
        for i, part in enumerate(parts):
            self.sendFrame(0 if i else 2 if isBinary else 1, part, fin=i + 1 == len(parts))

    def beginMessage(self, isBinary=False):
        self.opcode = 2 if isBinary else 1

    def beginMessageFrame(self, size):
        self.frame_key, self.frame_at = os.urandom(4), 0
        self.send(self.head(self.opcode, False, 0, size, self.frame_key))
        self.opcode = 0

    def sendMessageFrameData(self, payload):
        octets = payload.encode("latin-1")
        self.send(self.mask(self.frame_key, octets, self.frame_at))
        self.frame_at += len(octets)

    def endMessage(self):
        self.sendFrame(0, "", fin=True)

    def sendClose(self, code=None, reason=None):
        self.sendCloseFrame(code, reason)

    def sendCloseFrame(self, code=None, reasonUtf8=None, isReply=False):
        if self.state != self.STATE_OPEN:
            return
        octets = (b"" if code is None else struct.pack("!H", code)) + (reasonUtf8 or "").encode("latin-1")
        self.sendFrame(8, octets.decode("latin-1"))
        self.state = self.STATE_CLOSING
        self.closedByMe = not isReply
        self.localCloseReason = reasonUtf8
        if self.closedByMe:
            self.after(CLOSE_TIMEOUT_S, self.too_late, "no answer to the close frame in time")

    # -- the end --

    def too_late(self, what):
        if self.state != self.STATE_CLOSED:
            self.wasClean = False
            self.drop(what)

    def drop(self, why):
        self.late = self.late or why
        self.droppedByMe = True
        self.state = self.STATE_CLOSED
        try:
            self.socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # it is gone

    def awaits_the_end(self):
        self.after(CLOSE_TIMEOUT_S, self.too_late, "the TCP connection was not ended in time")

    # -- what arrives --

    def take(self, opcode, octets):
        payload = octets.decode("latin-1")
        if opcode == 9:
            if self.state == self.STATE_OPEN:
                self.sendFrame(10, payload)
                self.txFrameStats[10] = 0  # not of the case
            self.pinged = True
        elif opcode == 10:
            self.case.onPong(payload)
        elif opcode == 8:
            self.remoteCloseCode = struct.unpack("!H", octets[:2])[0] if len(octets) > 1 else None
            self.remoteCloseReason = octets[2:].decode("utf-8")
            self.wasClean = True
            if self.state == self.STATE_OPEN:
                self.sendCloseFrame(self.CLOSE_STATUS_CODE_NORMAL, isReply=True)
            self.awaits_the_end()
        elif opcode == 1 and json.loads(octets)["type"] in ("error", "reply"):
            self.answers += 1
            if not self.begun:
                self.unanswered.clear()
            elif not self.unanswered:
                self.case.received.append(("message", f"an answer to nothing: {payload}", False))
            elif not self.failedByMe:
                self.case.onMessage(self.unanswered.pop(0), False)

    async def need(self, size):
        while len(self.input) < size:
            more = await asyncio.get_running_loop().sock_recv(self.socket, 1 << 16)
            if not more:
                raise ConnectionError("the end")
            self.input += more

    async def read(self, size):
        await self.need(size)
        octets = bytes(self.input[:size])
        del self.input[:size]
        return octets

    async def handshake(self, port, path):
        key = base64.b64encode(os.urandom(16)).decode()
        self.send(
            f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: laglab.v2.bin\r\n\r\n".encode()
        )
        while b"\r\n\r\n" not in self.input:
            await self.need(len(self.input) + 1)
        head = await self.read(self.input.index(b"\r\n\r\n") + 4)
        if not head.startswith(b"HTTP/1.1 101"):
            raise ValueError(f"no upgrade: {head[:200]}")

    async def begin(self):
        self.state = self.STATE_OPEN
        self.sendFrame(1, '{"subscribe":{"session":1}}')
        await self.frames(until=lambda: self.pinged and not self.unanswered)
        self.txFrameStats.clear()
        self.answers = 0
        self.begun = True

    async def frames(self, until=lambda: False):
        while not until():
            first, second = await self.read(2)
            if first & 0x70 or second & 0x80 or first & 15 not in (1, 2, 8, 9, 10) or not first & 0x80:
                raise ValueError(f"the daemon sent a frame that begins with {first:02x} {second:02x}")
            size = second
            if size == 126:
                size = struct.unpack("!H", await self.read(2))[0]
            elif size == 127:
                size = struct.unpack("!Q", await self.read(8))[0]
            self.take(first & 15, await self.read(size))

    async def write(self):
        while True:
            octets = await self.queue.get()
            try:
                await asyncio.get_running_loop().sock_sendall(self.socket, octets)
            except OSError:
                return  # the reader sees it too
            if self.queue.qsize() % 64 == 0:
                await asyncio.sleep(0)

    async def run(self, name, kind, port, path):
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket.setblocking(False)
        self.case = kind(self)
        sender = asyncio.create_task(self.write())
        try:
            await asyncio.wait_for(self.handshake(port, path), OPEN_TIMEOUT_S)
            await asyncio.wait_for(self.begin(), OPEN_TIMEOUT_S)
            self.connectionWasOpen = True
            self.case.onOpen()
            await self.frames()
        except ConnectionError:
            pass
        finally:
            self.state = self.STATE_CLOSED
            for timer in self.timers:
                timer.cancel()
            sender.cancel()
            await asyncio.wait([sender])
            await asyncio.sleep(0)  # the loop lets go of the descriptor
            self.socket.close()
        self.case.onConnectionLost(self.failedByMe)
        size = getattr(self.case, "DATALEN", None)
        return {
            "case": name,
            "behaviour": self.case.behavior,
            "closing": self.case.behaviorClose,
            "code": self.remoteCloseCode,
            "reason": self.remoteCloseReason,
            "late": self.late,
            "result": self.case.result if self.case.behavior != "OK" else "",
            "answers": self.answers,
            "received": [str(part[0]) for part in self.case.received],
            "sent": self.txFrameStats,
            "bytes": size,
            "sends": plain(kind.DESCRIPTION),
            "expects": plain(kind.EXPECTATION),
        }


def plain(text):
    """A description without its markup, and its octets as text."""
    text = " ".join(re.sub(r"<[^>]*>", " ", text).split()).encode("latin-1").decode("utf-8", "replace")
    return text if len(text) <= 160 else text[:157] + "..."


async def main():
    options = argparse.ArgumentParser()
    options.add_argument("--testsuite", required=True)
    options.add_argument("--port", type=int, required=True)
    options.add_argument("--path", required=True)
    options.add_argument("--bytewise", action="store_true")
    options.add_argument("--only", default="")
    options.add_argument("--slack", type=float, default=1)
    options.add_argument("--at-once", type=int, default=8)
    wish = options.parse_args()
    only = [part for part in wish.only.split(",") if part]
    cases = [
        (name, kind)
        for name, kind in Suite(wish.testsuite).cases()
        if not only or any(name == part or name.startswith(f"{part}.") for part in only)
    ]
    free = asyncio.Semaphore(wish.at_once)

    async def one(name, kind):
        async with free:
            print(json.dumps(await Client(wish.bytewise, wish.slack).run(name, kind, wish.port, wish.path)), flush=True)

    await asyncio.gather(*(one(name, kind) for name, kind in cases))


asyncio.run(main())
