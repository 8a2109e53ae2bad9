#!/usr/bin/env python3
"""A program for peers.py in few lines: the tops of four-bar's cranks, which stay parallel, by fixed steps.

    parallel_cranks.py LOOPS END EVERY STEP OUT

It writes what peers.py reads: OUT/results.csv (t and the channels) and OUT/report.json (CPU seconds, counts).
"""
import json
import math
import pathlib
import sys
import time


def main():
    loops, out = int(sys.argv[1]), pathlib.Path(sys.argv[5])
    end, every, step = (float(word) for word in sys.argv[2:5])
    factor = 9.81 * (9 * loops + 3) / (8 * loops + 2)
    begin = time.process_time()
    angle, rate, rows, per_row = 0.0, 1.0, [], max(1, round(every / step))
    h, samples = every / per_row, round(end / every)
    for row in range(samples + 1):
        rows.append((row * every, angle))
        for _ in range(per_row if row < samples else 0):  # velocity Verlet
            rate += h / 2 * factor * math.sin(angle)
            angle += h * rate
            rate += h / 2 * factor * math.sin(angle)
    seconds = time.process_time() - begin
    with open(out / "results.csv", "w") as file:
        file.write("t" + "".join(f",top{k}.x,top{k}.z" for k in range(loops + 1)) + "\n")
        for t, a in rows:
            file.write(repr(t) + "".join(f",{k + math.sin(a)!r},{math.cos(a)!r}" for k in range(loops + 1)) + "\n")
    (out / "report.json").write_text(json.dumps({"cpu": seconds, "work": {"steps": samples * per_row}}))


if __name__ == "__main__":
    main()
