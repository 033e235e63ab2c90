"""A client of OPC UA by its bytes alone (OPC 10000-4 and -6), for peers that mean no good: it says whole requests as fast as
it can, and looks at what is answered no closer than it has to."""

import itertools
import struct

NOTHING = b"\xff\xff\xff\xff"  # a string, an array or a byte string that is null
POLICY = b"http://opcfoundation.org/UA/SecurityPolicy#None"
# Services, and the type of a session's user who is nobody, by their numbers in the binary encoding.
OPEN, CREATE, ACTIVATE, ACTIVATED, READ, WAS_READ, ANONYMOUS = 446, 461, 467, 470, 631, 634, 321
VALUE, EVER, BOTH_TIMES = 13, 600_000, 2


def words(*them):
    return b"".join(struct.pack("<I", it) for it in them)


def text(it):
    return words(len(it)) + it


def numbered(number):
    """The identifier of a type of the standard."""
    return struct.pack("<BBH", 1, 0, number)


def node(name):
    """The identifier of a variable, by its namespace and its name there."""
    return struct.pack("<BH", 3, name[0]) + text(name[1].encode())


def after_node(answer, at):
    """Where the identifier of a node ends that begins there."""
    kind = answer[at]
    if kind in (3, 5):
        return at + 7 + int.from_bytes(answer[at + 3 : at + 7], "little")
    return at + {0: 2, 1: 4, 2: 7, 4: 19}[kind]


class Channel:
    """A channel without security, with a session of nobody."""

    def __init__(self, stream, url):
        self.stream, self.token = stream, bytes(2)
        self.numbers = itertools.count(1)
        hello = words(0, 65536, 65536, 0, 0) + text(url)
        self.say(b"HELF", hello)
        self.hear(b"ACKF")
        policy = text(POLICY) + NOTHING * 2
        self.say(b"OPNF", words(0) + policy + self.service(OPEN, words(0, 0, 1) + NOTHING + words(EVER)))
        opened = self.hear(b"OPNF")
        at = 12 + len(policy) + 8 + 4 + 24  # headers, sequence, type, header of an answer
        _, self.channel, self.lease = struct.unpack_from("<III", opened, at)
        described = NOTHING * 2 + bytes(1) + words(1) + NOTHING * 3
        session = described + NOTHING + text(url) + text(b"flood") + text(bytes(32)) + NOTHING
        self.say(b"MSGF", self.request(CREATE, session + struct.pack("<d", EVER) + words(0)))
        created = self.hear(b"MSGF")
        begin = after_node(created, 24 + 4 + 24)
        self.token = created[begin : after_node(created, begin)]
        nobody = numbered(ANONYMOUS) + b"\x01" + text(text(b"anonymous"))
        self.say(b"MSGF", self.request(ACTIVATE, NOTHING * 4 + nobody + NOTHING * 2))
        if self.hear(b"MSGF")[24:28] != numbered(ACTIVATED):
            raise OSError("the session was refused")

    def say(self, kind, body):
        self.stream.sendall(self.message(kind, body))

    def hear(self, kind):
        """An answer as a whole, which is of that kind."""
        head = self.take(8)
        if head[:4] != kind:
            raise OSError(f"{kind} was expected, and {head} came")
        return head + self.take(int.from_bytes(head[4:], "little") - 8)

    def take(self, length):
        taken = b""
        while len(taken) < length:
            if not (more := self.stream.recv(length - len(taken))):
                raise OSError("it was closed")
            taken += more
        return taken

    @staticmethod
    def message(kind, body):
        return kind + words(8 + len(body)) + body

    @staticmethod
    def answers(held):
        """How many whole messages are readings that were granted, and what is left of `held`."""
        count = 0
        while len(held) >= 8 and len(held) >= (length := int.from_bytes(held[4:8], "little")):
            count += held[24:28] == numbered(WAS_READ)
            held = held[length:]
        return count, held

    def service(self, number, body):
        """With its place in the sequence, and the header of a request without limits."""
        place = next(self.numbers)
        header = self.token + bytes(8) + words(place, 0) + NOTHING + words(0) + bytes(3)
        return words(place, place) + numbered(number) + header + body

    def request(self, number, body):
        return words(self.channel, self.lease) + self.service(number, body)

    def readings(self, names, count):
        """So many requests, each of which reads the values of all `names`."""
        wanted = b"".join(node(name) + words(VALUE) + NOTHING + bytes(2) + NOTHING for name in names)
        body = bytes(8) + words(BOTH_TIMES, len(names)) + wanted
        return b"".join(self.message(b"MSGF", self.request(READ, body)) for _ in range(count))
