"""Decodes frames with cantools, for comparison.

Standard input has a command a line:
  D PATH               load this DBC
  I                    describe it: a line per message and signal, then "end"
  F MESSAGE HEXBYTES   decode; answers one line, SIGNAL=STATE for each signal in name order
STATE is V:raw:physical, A where a multiplexor does not select the signal, S where the payload is
too short. Integers are decimal, floats the 16 hexadecimal digits of their double.
"""

import struct
import sys

import cantools
from cantools.database.can import Message, Signal
from cantools.database.errors import DecodeError

EXACT = 2**53


def bits(number):
    number = float(number)
    if number != number:
        return "nan"
    return struct.pack(">d", number).hex()


def raw_text(raw):
    return bits(raw) if isinstance(raw, float) else str(raw)


def physical(signal, raw, scaled):
    """What a calculation in doubles gives. cantools calculates whole numbers without a limit: where
    that makes a difference, it must be one of rounding. Zero has no sign."""
    scale, offset = signal.scale, signal.offset
    if isinstance(raw, int) and max(abs(raw), abs(raw * scale), abs(scaled)) > EXACT:
        double = float(raw) * float(scale) + float(offset)
        size = max(abs(float(raw) * float(scale)), abs(float(offset)), 1.0)
        assert abs(double - scaled) <= 2.0**-51 * size, (signal.name, raw, scaled)
        return double
    return scaled + 0.0


class Decoder:
    def __init__(self, path):
        self.database = cantools.database.load_file(path, strict=True)
        self.alone = {}

    def describe(self):
        for message in self.database.messages:
            flag = "x" if message.is_extended_frame else "s"
            print(f"message {message.name} {message.frame_id}{flag} {message.length}")
            for signal in message.signals:
                limits = "-"
                if signal.minimum is not None:
                    limits = f"{bits(signal.minimum)},{bits(signal.maximum)}"
                names = ";".join(f"{n}={t}" for n, t in sorted((signal.choices or {}).items()))
                print(f"signal {signal.name} {limits} [{signal.unit or ''}] {names}")
        print("end")

    def decode_alone(self, message, signal, data, scaling):
        """As if the message had this signal only: for frames whose multiplexor value is unknown,
        which cantools refuses as a whole."""
        key = (message.name, signal.name)
        if key not in self.alone:
            copy = Signal(name=signal.name, start=signal.start, length=signal.length,
                          byte_order=signal.byte_order, is_signed=signal.is_signed,
                          conversion=signal.conversion)
            self.alone[key] = Message(frame_id=1, name="Alone", length=message.length,
                                      signals=[copy])
        return self.alone[key].decode(data, decode_choices=False, scaling=scaling,
                                      allow_truncated=True, allow_excess=True)

    def decode_all(self, message, data, scaling):
        try:
            return message.decode(data, decode_choices=False, scaling=scaling,
                                  allow_truncated=True, allow_excess=True)
        except DecodeError as error:
            if "expected multiplexer id" not in str(error):
                raise
        found = {}
        for signal in message.signals:
            found.update(self.decode_alone(message, signal, data, scaling))
        by_name = {signal.name: signal for signal in message.signals}

        def selected(signal, raw):
            if signal.multiplexer_signal is None:
                return True
            above = by_name[signal.multiplexer_signal]
            return (selected(above, raw) and above.name in raw
                    and raw[above.name] in signal.multiplexer_ids)

        raw = {}
        for signal in message.signals:
            raw.update(self.decode_alone(message, signal, data, False))
        return {name: value for name, value in found.items() if selected(by_name[name], raw)}

    def decode(self, name, data):
        message = self.database.get_message_by_name(name)
        raw = self.decode_all(message, data, False)
        scaled = self.decode_all(message, data, True)
        by_name = {signal.name: signal for signal in message.signals}

        def state(signal):
            if signal.name in raw:
                number = raw[signal.name]
                value = physical(signal, number, scaled[signal.name])
                return f"V:{raw_text(number)}:{bits(value)}"
            if signal.multiplexer_signal is None:
                return "S"
            above = by_name[signal.multiplexer_signal]
            if above.name not in raw:
                return state(above)
            return "S" if raw[above.name] in signal.multiplexer_ids else "A"

        return " ".join(f"{n}={state(by_name[n])}" for n in sorted(by_name))


def main():
    decoder = None
    for line in sys.stdin:
        command, *words = line.split()
        if command == "D":
            decoder = Decoder(words[0])
        elif command == "I":
            decoder.describe()
        else:
            data = bytes.fromhex(words[1]) if len(words) > 1 else b""
            print(decoder.decode(words[0], data))


main()
