"""A swallow-tailed flag with a sun on it, a fine sheet in the plane z = 0: flag.obj."""

import os

from modelling import Model

LENGTH, HEIGHT, ACROSS, UP = 1.8, 1.2, 72, 48
flag = Model("flag", {"blue": ("#1f4e8c", 0.85, 0), "white": ("#ece6d8", 0.85, 0),
                      "red": ("#b5282d", 0.85, 0), "sun": ("#e9b52c", 0.8, 0)})


def colour(x, y):
    if (x - 0.62) ** 2 + (y - HEIGHT / 2) ** 2 < 0.23 ** 2:
        return "sun"
    return "red" if y < HEIGHT / 3 else "white" if y < 2 * HEIGHT / 3 else "blue"


if __name__ == "__main__":
    def place(i, j):
        y = HEIGHT * j / UP
        # The tail is cut in by a V, a third of the length deep.
        end = LENGTH * (1 - 0.33 * (1 - abs(2 * y / HEIGHT - 1)))
        return (end * i / ACROSS, y, 0)

    ids = {}
    for j in range(UP + 1):
        for i in range(ACROSS + 1):
            ids[i, j] = flag.vertex(place(i, j))
    for j in range(UP):
        for i in range(ACROSS):
            a, b = place(i, j), place(i + 1, j + 1)
            flag.use("flag", colour((a[0] + b[0]) / 2, (a[1] + b[1]) / 2))
            flag.face((ids[i, j], ids[i + 1, j], ids[i + 1, j + 1], ids[i, j + 1]))
    flag.write(os.path.dirname(os.path.abspath(__file__)))
