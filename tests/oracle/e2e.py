"""AUTOSAR E2E profile 5 by cantools, as a filter.

Each line of standard input is `DATA_ID FRAME`, both hexadecimal; the answer to it is
`VALID PROTECTED`: 1 or 0, whether the frame's CRC is right as it stands, and the frame with the CRC
that cantools gives it.
"""

import sys

from cantools.autosar import end_to_end

for line in sys.stdin:
    data_id, frame = line.split()
    data_id, frame = int(data_id, 16), bytes.fromhex(frame)
    valid = end_to_end.check_profile5_crc(frame, data_id)
    protected = end_to_end.apply_profile5_crc(frame, data_id)
    print(int(valid), protected.hex())
