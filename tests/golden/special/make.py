"""Writes exponential_integral.json: E1(z), e^z E1(z), and the auxiliary functions f, g, by mpmath at 80 digits."""
import json, math
import mpmath as mp

mp.mp.dps = 80
number = lambda x: float(mp.nstr(x, 25))
rows = []
for radius in [1e-12, 1e-3, 0.1, 0.7, 1.5, 2.0, 3.0, 5.0, 9.0, 20.0, 45.0, 59.0, 61.0, 130.0, 700.0, 5e3]:
    for angle in [0.0, 0.5, 1.2, math.pi / 2, 2.0, 2.6, 3.0, 3.13, 3.14159, math.pi]:
        for sign in ([1, -1] if angle in (1.2, 3.0, math.pi) else [1]):
            z = complex(radius * math.cos(angle), sign * radius * math.sin(angle))
            if angle == 0.0:
                z = complex(radius, 0.0)
            if angle == math.pi:
                z = complex(-radius, 0.0)
            at = mp.mpc(z)
            e1 = mp.e1(at)
            if angle == math.pi:
                # The limit from above (sign 1) or below the cut.
                e1 = mp.mpc(-mp.ei(radius), -sign * mp.pi)
            scaled = mp.exp(at) * e1
            value = [number(e1.real), number(e1.imag)] if abs(z.real) < 700 else None
            rows.append([[z.real, z.imag if angle != math.pi else sign * 0.0], value, [number(scaled.real), number(scaled.imag)]])
auxiliary = []
for x in [1e-12, 1e-3, 0.2, 1.0, 2.9, 3.1, 7.0, 25.0, 59.9, 60.1, 300.0, 1e6, 1e15]:
    at = mp.mpf(x)
    f = mp.ci(at) * mp.sin(at) + (mp.pi / 2 - mp.si(at)) * mp.cos(at)
    g = -mp.ci(at) * mp.cos(at) + (mp.pi / 2 - mp.si(at)) * mp.sin(at)
    auxiliary.append([x, number(f), number(g)])
with open("exponential_integral.json", "w") as out:
    json.dump({"e1": rows, "auxiliary": auxiliary}, out, indent=None, separators=(",", ":"))
    out.write("\n")
