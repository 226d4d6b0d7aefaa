#!/usr/bin/python3
"""Logs a session that runs: tool, force and the touched scene at 100 Hz, as CSV (docs/python.md).

    logger.py SESSION SECONDS >log.csv
"""
import sys
import time

import stillgrid

session, seconds = sys.argv[1], float(sys.argv[2])
print("time_s,x_m,y_m,z_m,fx_N,fy_N,fz_N,contacts,safety_flags,snapshot_id,spheres")
end_s, seen = time.monotonic() + seconds, None
with stillgrid.Reader(session) as reader:
    while time.monotonic() < end_s:
        reader.poll()  # the writers may come and go
        tool, snapshot = reader.tool(), reader.snapshot()
        if tool is not None and tool.tick != seen:
            seen = tool.tick
            figures = [1e-9 * tool.time_ns, *tool.position_m, *tool.force_N, tool.contacts,
                       tool.safety_flags, tool.snapshot_id, 0 if snapshot is None else len(snapshot.radii_m)]
            print(*figures, sep=",", flush=True)
        time.sleep(0.01)
