"""python-can's LogReader and cantools' decode over a recording; frames and seconds as JSON.

    reference.py LOG DBC MOST_FRAMES

Imports and the loading of the DBC are not in the seconds.
"""

import json
import sys
import time

import can
import cantools


def main():
    log, dbc, most = sys.argv[1], sys.argv[2], int(sys.argv[3])
    database = cantools.database.load_file(dbc)
    known = {message.frame_id: message for message in database.messages}
    frames = 0
    wall, cpu = time.perf_counter(), time.process_time()
    for message in can.LogReader(log):
        definition = known.get(message.arbitration_id)
        if definition is not None:
            definition.decode(message.data, decode_choices=False)
        frames += 1
        if frames == most:
            break
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    print(json.dumps({"frames": frames, "wall": wall, "cpu": cpu}))


if __name__ == "__main__":
    main()
