"""Six soft skittles in a triangle, the first towards +x: skittles.obj."""

import math
import os

from modelling import Model

SIDES, ROWS, APART = 24, 3, 0.17  # m from axis to axis
RED, WHITE = "stripe", "skittle"

# (height, radius) from the foot to the top, m; the stripe goes round the neck.
OUTLINE = [(0.0, 0.026), (0.004, 0.031), (0.03, 0.042), (0.06, 0.053), (0.09, 0.06), (0.115, 0.062),
           (0.14, 0.06), (0.17, 0.053), (0.2, 0.044), (0.225, 0.036), (0.25, 0.031), (0.265, 0.03),
           (0.285, 0.032), (0.305, 0.0365), (0.325, 0.04), (0.345, 0.0395), (0.362, 0.034),
           (0.374, 0.024), (0.38, 0.012)]
STRIPE = (0.235, 0.27)


def add_skittle(model, x, z):
    rings = [[(x + r * math.cos(2 * math.pi * i / SIDES), y, z - r * math.sin(2 * math.pi * i / SIDES))
              for i in range(SIDES)] for y, r in OUTLINE]
    numbers = [[model.vertex(p) for p in ring] for ring in rings]
    model.use("skittle", WHITE)
    for ring, pole, up in ((numbers[0], (x, 0, z), False), (numbers[-1], (x, 0.382, z), True)):
        centre = model.vertex(pole)
        for i in range(SIDES):
            a, b = ring[i], ring[(i + 1) % SIDES]
            model.face([a, b, centre] if up else [b, a, centre])
    for k, (low, high) in enumerate(zip(numbers, numbers[1:])):
        middle = (OUTLINE[k][0] + OUTLINE[k + 1][0]) / 2
        model.use("skittle", RED if STRIPE[0] < middle < STRIPE[1] else WHITE)
        for i in range(SIDES):
            j = (i + 1) % SIDES
            model.face([low[i], low[j], high[j], high[i]])


if __name__ == "__main__":
    skittles = Model("skittles", {WHITE: ("#e9e2d0", 0.35, 0), RED: ("#b3161b", 0.35, 0)})
    for row in range(ROWS):
        for k in range(row + 1):
            add_skittle(skittles, -row * APART * math.sqrt(3) / 2, (k - row / 2) * APART)
    skittles.write(os.path.dirname(os.path.abspath(__file__)))
