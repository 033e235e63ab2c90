"""The ship's systems that behave badly: clients of Modbus and OPC UA, and a broker; run by window.py."""

import os
import socket
import threading
import time

import opcua_raw

MODBUS, BROKER, OPCUA = 9494, 9495, 9496
FLOODING, NOT_TAKING, HANGING, KNOCKING = 3, 2, 2, 2  # clients of a protocol; there are eight places
CONNACK, PUBACK = bytes([0x20, 3, 0, 0, 0]), 0x40


class Modbus:
    """A connection that asks for the registers of the machine."""

    name, port = "Modbus", MODBUS

    def __init__(self, _client):
        """There is nothing to say first."""

    def requests(self, count):
        return bytes([0, 7, 0, 0, 0, 6, 1, 4, 0, 0, 0, 30]) * count

    @staticmethod
    def answers(held):
        """How many whole ones there are, and what is left of `held`."""
        count = len(held) // 69
        return count, held[69 * count :]


class OpcUa(opcua_raw.Channel):
    """A connection with a session that reads eleven variables of each of three cylinders, in one request."""

    name, port = "OPC UA", OPCUA
    nodes = [
        (2, f"cylinder_{number}_{of}")
        for number in (1, 2, 3)
        for of in "c1 c2 c1_lamp c2_lamp r1 r2 r3 estimate sigma incident incident_level".split()
    ]

    def __init__(self, client):
        super().__init__(client, f"opc.tcp://127.0.0.1:{OPCUA}/".encode())

    def requests(self, count):
        return self.readings(self.nodes, count)


class Peers:
    """Clients of each protocol that ask without a pause, that do not take their answers, that leave a request half sent, and
    that connect again and again; and a broker that is a bad one in another way for each connection."""

    def __init__(self, protocols, orders):
        self.over = threading.Event()
        self.connections = {it.name: 0 for it in protocols}
        self.answers = {it.name: 0 for it in protocols}
        self.messages = self.brokers = 0
        self.first = os.getpid()
        ways = [self.flood] * FLOODING + [self.stuff] * NOT_TAKING + [self.hang] * HANGING + [self.knock] * KNOCKING
        work = [(way, (it,)) for it in protocols for way in ways]
        self.listener = socket.create_server(("127.0.0.1", BROKER))
        self.listener.settimeout(0.5)
        self.threads = [threading.Thread(target=it, args=of, daemon=True) for it, of in [*work, (self.broke, ())]]
        for thread in self.threads:
            thread.start()
        orders.recv()
        self.over.set()
        for thread in self.threads:
            thread.join(10)
        counts = {f"{name} {what}": count for what in ("connections", "answers") for name, count in getattr(self, what).items()}
        orders.send({**counts, "messages": self.messages, "brokers": self.brokers})

    def client(self, protocol, with_it):
        """A connection after the other, until it is over."""
        while not self.over.is_set():
            try:
                with socket.create_connection(("127.0.0.1", protocol.port), timeout=3.0) as client:
                    self.connections[protocol.name] += 1
                    with_it(client)
            except OSError:
                self.over.wait(0.05)

    def flood(self, protocol):
        def ask(client):
            speech, held = protocol(client), b""
            while not self.over.is_set():
                client.sendall(speech.requests(100))
                if not (answer := client.recv(1 << 20)):
                    return
                count, held = speech.answers(held + answer)
                self.answers[protocol.name] += count

        self.client(protocol, ask)

    def stuff(self, protocol):
        def ask(client):
            speech = protocol(client)
            while not self.over.is_set():
                client.sendall(speech.requests(1000))

        self.client(protocol, ask)

    def hang(self, protocol):
        def half(client):
            client.sendall(protocol(client).requests(1)[:7])
            self.over.wait(5.0)

        self.client(protocol, half)

    def knock(self, protocol):
        self.client(protocol, lambda _client: None)

    def broke(self):
        while not self.over.is_set():
            try:
                client, _ = self.listener.accept()
            except TimeoutError:
                continue
            way = [self.silent, self.deaf, self.flooding, self.good][(self.first + self.brokers) % 4]
            self.brokers += 1
            with client:
                client.settimeout(0.5)
                try:
                    way(client)
                except OSError:
                    pass

    def silent(self, _client):
        self.over.wait(5.0)

    def deaf(self, client):
        client.sendall(CONNACK)
        self.over.wait(5.0)

    def flooding(self, client):
        client.sendall(CONNACK)
        while not self.over.is_set():
            client.sendall(bytes([0x30, 5, 0, 1, 97, 0, 98]) * 1000)

    def good(self, client):
        """Acknowledges everything for some seconds."""
        held, end = b"", time.monotonic() + 5.0
        client.recv(4096)
        client.sendall(CONNACK)
        while not self.over.is_set() and time.monotonic() < end:
            try:
                held += client.recv(65536)
            except TimeoutError:
                continue
            while (packet := self.packet(held)) is not None:
                kind, body, held = packet
                if kind >> 4 == 3:
                    at = 2 + int.from_bytes(body[:2], "big")
                    client.sendall(bytes([PUBACK, 2]) + body[at : at + 2])
                    self.messages += 1
                elif kind >> 4 == 12:
                    client.sendall(bytes([0xD0, 0]))

    @staticmethod
    def packet(held):
        """First byte, body and rest; nothing where it is not whole."""
        length = shift = 0
        for place, byte in enumerate(held[1:5], 1):
            length |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                end = place + 1 + length
                return (held[0], held[place + 1 : end], held[end:]) if len(held) >= end else None
        return None
