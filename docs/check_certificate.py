#!/usr/bin/env python3
"""Checks a passivity certificate with nothing but Python: docs/certificates.md by hand.

    check_certificate.py FILE [POINTS]

Passive: the intervals cover (0, pi/T] and leave a margin; at POINTS of them (all without it) the law, the aliased
disk and the inequality |1 + H c| > |H| r are computed again from the device's and the law's matrices.
Not passive: the operator is attached and the loop's largest pole computed, or the damping or the disk where it fails.
What lies between the points is not checked here: gyrator verify-certificate does.
"""
import cmath
import json
import math
import sys
from fractions import Fraction

LAST = 10**6       # alias beyond which the response is taken not to change
TOLERANCE = 1e-4   # of what bands of aliases leave out, relative to the radius


def solve(matrix, columns):
    """X with matrix X = columns, by Gauss with pivots."""
    rows = [list(a) + list(b) for a, b in zip(matrix, columns)]
    n = len(rows)
    for i in range(n):
        best = max(range(i, n), key=lambda k: abs(rows[k][i]))
        rows[i], rows[best] = rows[best], rows[i]
        for k in range(n):
            if k != i and rows[k][i]:
                factor = rows[k][i] / rows[i][i]
                rows[k] = [x - factor * y for x, y in zip(rows[k], rows[i])]
    return [[x / rows[i][i] for x in rows[i][n:]] for i in range(n)]


def response(system, s):
    """C (s - A)^-1 B + D."""
    pencil = [[(s if i == j else 0) - a for j, a in enumerate(row)] for i, row in enumerate(system["A"])]
    x = solve(pencil, system["B"])
    return [[d + sum(c * x[k][j] for k, c in enumerate(row)) for j, d in enumerate(direct)]
            for row, direct in zip(system["C"], system["D"])]


def port(device, omega):
    """Re Z, S A and M of f = Z v - A u, v_s = S v + M u."""
    g = response(device, 1j * omega)
    sensed = g[1] if len(g) > 1 else [0, 1]
    return g[0][1].real, -sensed[1] * g[0][0], sensed[0]


def bands():
    """(n, n, n + 1) one by one, then (middle, first, end) of longer and longer bands of aliases."""
    first = 1
    while first < LAST:
        end = max(first + 1, int(first * 1.05))
        yield (first + end - 1) / 2, first, end
        first = end
    yield first, first, math.inf


def disk(device, period, delay, omega):
    """Re Z, centre and radius (disk-1)."""
    rate, share = 2 * math.pi / period, omega * period / (2 * math.pi)
    base, path, blocked = port(device, omega)
    centre, radius = (blocked + path / (2 * base)) / omega**2, abs(path) / (2 * base) / omega**2
    turn = cmath.exp(-1j * rate * delay)
    for middle, first, end in bands():
        for side in (1, -1):
            damping, path, blocked = port(device, omega + side * middle * rate)
            if damping <= 0:
                raise ValueError(f"Re Z = {damping} at {omega + side * middle * rate} rad/s")
            # sum over first <= n < end of (n + side share)^-2; over a band nearly the integral.
            weight = 1 / (first - 0.5 + side * share) - 1 / (end - 0.5 + side * share)
            if end == first + 1:
                weight = 1 / (first + side * share)**2
            weight /= rate**2
            radius += weight * abs(path) / (2 * damping)
            if end == first + 1 or abs(turn - 1) < 1e-9:  # what turns sums to almost nothing over a band
                centre += weight * turn**(side * middle) * (blocked + path / (2 * damping))
    factor = -(1 - cmath.exp(-1j * omega * period)) * cmath.exp(-1j * omega * delay) / period
    return base, factor * centre, abs(factor) * radius


def product(a, b):
    columns = list(zip(*b))
    return [[sum(x * y for x, y in zip(row, column)) for column in columns] for row in a]


def exponential(matrix):
    size = max(sum(map(abs, row)) for row in matrix) + 1e-300
    halvings = max(0, math.ceil(math.log2(size)) + 2)
    matrix = [[x / 2**halvings for x in row] for row in matrix]
    result = term = [[float(i == j) for j in range(len(matrix))] for i in range(len(matrix))]
    for k in range(1, 20):
        term = [[x / k for x in row] for row in product(term, matrix)]
        result = [[x + y for x, y in zip(*rows)] for rows in zip(result, term)]
    for _ in range(halvings):
        result = product(result, result)
    return result


def largest_pole(device, law, period, delay, held):
    """Of the loop u = -H y with an operator at the port: the norm of a high power of its matrix."""
    n, hung = len(device["A"]), held.get("resonators", [])
    spring = held.get("stiffness", 0) > 0
    first = n + 1 + spring
    y = first + 2 * len(hung)
    inertia = device["port_inertia"] + held.get("inertia", 0)
    plant = [[0.0] * (y + 2) for _ in range(y + 2)]  # states [x; v; e; v_i, e_i; y], then u
    for i in range(n):
        plant[i][:n + 1] = device["A"][i] + [device["B"][i][1]]
        plant[i][-1] = device["B"][i][0]
    c, d = device["C"][0], device["D"][0]
    plant[n][:n + 1] = [-x / inertia for x in c + [d[1] + held.get("damping", 0)]]
    plant[n][-1] = -d[0] / inertia
    if spring:
        plant[n][n + 1], plant[n + 1][n] = -held["stiffness"] / inertia, 1.0
    for i, r in enumerate(hung):
        speed, stretch = first + 2 * i, first + 2 * i + 1
        plant[n][stretch], plant[stretch][n], plant[stretch][speed] = -r["stiffness"] / inertia, 1.0, -1.0
        plant[speed][stretch] = r["stiffness"] / r["inertia"]
    if len(device["C"]) == 1:
        plant[y][n] = 1.0
    else:
        plant[y][:n + 1] = device["C"][1] + [device["D"][1][1]]
        plant[y][-1] = device["D"][1][0]
    whole, rest = divmod(Fraction(delay), Fraction(period))
    recent = exponential([[float(period - rest) * x for x in row] for row in plant])
    late = exponential([[float(rest) * x for x in row] for row in plant])
    q, m = len(law["A"]), int(whole) + 1
    size = y + 1 + q + m
    commands = [[0.0] * size for _ in range(m + 1)]  # the newest, then those under way
    commands[0][y], commands[0][y + 1:y + 1 + q] = -law["D"][0][0], [-x for x in law["C"][0]]
    for i in range(m):
        commands[i + 1][y + 1 + q + i] = 1.0
    state = [[float(i == j) for j in range(size)] for i in range(y + 1)]
    middle = product(late, state + [commands[m]])
    loop = product(recent, middle[:y + 1] + [commands[m - 1]])[:y + 1]
    for i in range(q):
        loop.append([0.0] * y + [law["B"][i][0]] + law["A"][i] + [0.0] * m)
    loop += commands[:m]
    log_size = 0.0  # of the power taken out, per period
    for k in range(40):
        largest = max(max(map(abs, row)) for row in loop)
        log_size += math.log(largest) / 2**k
        loop = [[x / largest for x in row] for row in loop]
        loop = product(loop, loop)
    return math.exp(log_size)


def check(condition, text):
    if not condition:
        sys.exit(f"NOT VERIFIED: {text}")


def check_passive(device, loop, period, delay, points):
    columns = loop["intervals"]
    intervals = [dict(zip(columns, row)) for row in zip(*columns.values())]
    edge = math.pi / period
    for i in intervals:
        check(abs(i["omega"] + i["reach"] - edge) <= 1e-9 * edge, f"a gap at {edge} rad/s")
        edge = i["omega"] - i["reach"]
        check(i["margin"] - (abs(i["slope"]) + i["curvature"] * i["reach"]) * i["reach"] > 0, f"no margin at {edge} rad/s")
    check(largest_pole(device, loop["law"], period, delay, {}) < 1 + 1e-7, "unstable with nothing attached")
    for i in intervals[::max(1, len(intervals) // points)]:
        omega, h = i["omega"], complex(i["law_real"], i["law_imag"])
        law = response(loop["law"], cmath.exp(1j * omega * period))[0][0]
        check(abs(law - h) <= 1e-7 * abs(law), f"H at {omega} rad/s")
        if law == 0:  # nothing is commanded: D = Re Z, whatever the disk
            check(i["margin"] <= port(device, omega)[0] * (1 + 1e-9), f"the margin at {omega} rad/s")
            continue
        damping, centre, radius = disk(device, float(period), float(delay), omega)
        recorded, r = complex(i["center_real"], i["center_imag"]), i["radius"]
        check(abs(recorded - centre) + radius <= r * (1 + TOLERANCE), f"the disk at {omega} rad/s")
        check(r <= 1.02 * radius, f"the radius at {omega} rad/s")
        margin = damping * (abs(1 + h * recorded)**2 - abs(h * r)**2)
        rounding = 1e-14 * damping * abs(h * r)**2  # of the difference of two large numbers
        check(margin > 0 and abs(margin - i["margin"]) <= 1e-6 * margin + rounding, f"the margin at {omega} rad/s")
    return len(intervals)


def main(path, points=10**9):
    with open(path, encoding="utf-8") as file:
        certificate = json.load(file)
    period, delay = Fraction(certificate["period_s"]), Fraction(certificate["delay_s"])
    device = certificate["device"]
    for loop in certificate["loops"]:
        if certificate["verdict"] == "passive":
            print(f"{loop['name']}: {check_passive(device, loop, period, delay, points)} intervals")
            continue
        found = loop["refutation"]
        if found["kind"] in ("operator", "uncoupled"):
            held = found if found["kind"] == "operator" else {}
            check(all(held.get(k, 0) >= 0 for k in ("inertia", "damping", "stiffness")), "not a passive operator")
            pole = largest_pole(device, loop["law"], period, delay, held)
            check(pole > 1 and abs(pole - found["spectral_radius"]) < 1e-6, f"largest pole {pole}")
        elif found["kind"] == "device":
            check(port(device, found["omega"])[0] <= 0, "Re Z is above zero")
        else:
            h = response(loop["law"], cmath.exp(1j * found["omega"] * period))[0][0]
            _, centre, radius = disk(device, float(period), float(delay), found["omega"])
            check(abs(1 + h * centre) <= abs(h) * radius * (1 + TOLERANCE), "the disk is not exceeded")
        print(f"{loop['name']}: not passive by {found['kind']}")
    print("VERIFIED")


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:3]))
