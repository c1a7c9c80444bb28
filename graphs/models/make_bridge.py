#!/usr/bin/env python3
"""Writes bridge.obj and bridge.mtl: a suspension bridge, 60 m from abutment to abutment.

It is modelled as bridges for pictures are: it looks right, and little of it would hold. All the
shortcuts that make such a model hard to simulate are put in on purpose, each marked SHORTCUT below:
cables and hangers whose ends miss what they should hold by centimetres, parts that pass through
each other, gaps narrower than any cube, slivers, isolated polygons, duplicate faces, faces wound
the wrong way, and tubes with open ends.

James, Barbic, Twigg. Squashing cubes: automating deformable model construction for graphics.
SIGGRAPH 2004 sketches: "modeling shortcuts" of just these kinds.
"""

import os

from modelling import Model, circle, i_beam, rectangle

MATERIALS = {  # colour, roughness, metallic
    "steel": ("#b5402c", 0.45, 0.0),      # painted, international orange
    "girder": ("#8f3325", 0.5, 0.0),      # the same paint in the shade of the deck
    "deck": ("#7d8288", 0.7, 0.0),
    "asphalt": ("#3a3c40", 0.95, 0.0),
    "paving": ("#a39c90", 0.9, 0.0),
    "marking": ("#e9e4d4", 0.8, 0.0),
    "railing": ("#31565c", 0.4, 0.0),
    "cable": ("#4b4a4d", 0.35, 0.6),
    "hanger": ("#6a6a6e", 0.35, 0.6),
    "concrete": ("#c4bbab", 0.9, 0.0),
    "footing": ("#9a938a", 0.95, 0.0),
    "brass": ("#c79a4b", 0.3, 0.9),
    "lamp": ("#fff1c9", 0.3, 0.0),
}

SPAN = 60.0        # m, between the abutments
TOWER = 18.0       # m, from the middle to each tower
TOWER_TOP = 18.0   # m
CABLE_Z = 2.75     # m, the planes of the two cables
ROAD = 1.9         # m, half the width of the road
CAMBER = 0.7       # m, the deck's rise in the middle
LEVEL = 7.0        # m, the deck's height at its ends

bridge = Model("bridge", MATERIALS, decimals=3)


def deck_y(x):
    """The road's height: a flat arch."""
    return LEVEL + CAMBER * (1 - (2 * x / SPAN) ** 2)


def cable_y(x):
    """The main cable's height: a parabola in the main span, straight to the anchors outside."""
    top, low = TOWER_TOP - 0.35, deck_y(0) + 1.0
    if abs(x) <= TOWER:
        return low + (top - low) * (x / TOWER) ** 2
    t = (abs(x) - TOWER) / (SPAN / 2 - TOWER)
    sag = 0.35 * 4 * t * (1 - t)
    return top + (deck_y(SPAN / 2) + 0.35 - top) * t - sag


def stations(start, end, step):
    n = max(1, round((end - start) / step))
    return [start + (end - start) * i / n for i in range(n + 1)]


def along(profile, start, end, y, z, step=0.75, caps=True):
    """A profile swept along the deck's arch."""
    bridge.sweep(profile, [(x, deck_y(x) + y, z) for x in stations(start, end, step)], caps=caps)


def road():
    half = SPAN / 2
    # The roadway lies in panels. SHORTCUT: 1 cm gaps between them, narrower than any cube.
    panels = stations(-half, half, 3.0)
    for a, b in zip(panels, panels[1:]):
        bridge.use("deck", "deck")
        along(rectangle(5.9, 0.18), a + 0.005, b - 0.005, -0.21, 0, 0.75)
        bridge.use("road", "asphalt")
        along(rectangle(2 * ROAD, 0.12), a + 0.005, b - 0.005, -0.06, 0, 0.75)
    for side in (-1, 1):
        bridge.use("walkway", "paving")
        along(rectangle(0.62, 0.22, 0.03), -half, half, 0.0, side * (ROAD + 0.31))
        # Edge lines: strips without thickness. SHORTCUT: they float 4 mm above the asphalt.
        bridge.use("markings", "marking")
        for x in stations(-half, half, 1.5)[:-1]:
            edge = side * (ROAD - 0.22)
            bridge.polygon([(x, deck_y(x) + 0.004, edge + 0.05),
                            (x + 1.5, deck_y(x + 1.5) + 0.004, edge + 0.05),
                            (x + 1.5, deck_y(x + 1.5) + 0.004, edge - 0.05),
                            (x, deck_y(x) + 0.004, edge - 0.05)])
    for k, x in enumerate(stations(-half, half, 1.5)[:-1]):
        if k % 2 == 0:
            bridge.polygon([(x, deck_y(x) + 0.004, 0.06), (x + 1.5, deck_y(x + 1.5) + 0.004, 0.06),
                            (x + 1.5, deck_y(x + 1.5) + 0.004, -0.06),
                            (x, deck_y(x) + 0.004, -0.06)])


def girders():
    half = SPAN / 2
    for side in (-1, 1):
        z = side * 2.45
        bridge.use("girders", "girder")
        along(i_beam(0.34, 0.95, 0.07, 0.06), -half, half, -0.78, z, 0.6)
        bridge.use("girders", "steel")
        # Stiffeners on the web, one a cross beam, and rivet heads along both flanges.
        for k, x in enumerate(stations(-half + 0.75, half - 0.75, 1.5)):
            bridge.box((x, deck_y(x) - 0.78, z + side * 0.1), (0.05, 0.8, 0.13))
        for x in stations(-half + 0.3, half - 0.3, 0.6):
            for y in (-0.415, -1.145):
                bridge.dome((x, deck_y(x) + y - 0.02, z + side * 0.165), (0, 0, side), 0.032, 5)
    # SHORTCUT: the cross beams run right through both girders' webs, and 12 cm beyond.
    bridge.use("cross_beams", "girder")
    for x in stations(-half + 1.5, half - 1.5, 1.5):
        bridge.bar(i_beam(0.2, 0.5, 0.05, 0.05), (x, deck_y(x) - 0.58, -2.95),
                   (x, deck_y(x) - 0.58, 2.95), 4)
    # Wind bracing: crossed angles below the deck, through each other at every crossing.
    bridge.use("bracing", "girder")
    xs = stations(-half + 1.5, half - 1.5, 3.0)
    for a, b in zip(xs, xs[1:]):
        for side in (-1, 1):
            bridge.bar(rectangle(0.09, 0.09), (a, deck_y(a) - 1.08, side * 2.4),
                       (b, deck_y(b) - 1.08, -side * 2.4), 4)


def railings():
    half = SPAN / 2
    for side in (-1, 1):
        z = side * 2.58
        bridge.use("railing", "railing")
        for k, x in enumerate(stations(-half + 0.5, half - 0.5, 1.0)):
            first = len(bridge.faces)
            bridge.bar(rectangle(0.06, 0.07), (x, deck_y(x) + 0.1, z), (x, deck_y(x) + 1.12, z))
            if k % 9 == 4:  # SHORTCUT: some posts were mirrored by hand, and their faces turned
                for i in range(first, len(bridge.faces)):
                    group, material, corners = bridge.faces[i]
                    bridge.faces[i] = (group, material, tuple(reversed(corners)))
        # SHORTCUT: the rails are tubes with open ends.
        for y, r in ((1.14, 0.045), (0.78, 0.022), (0.46, 0.022)):
            along(circle(r, 6), -half, half, y, z, 1.0, caps=False)
        # Balusters: flat strips without thickness, seen from both sides.
        for x in stations(-half + 0.25, half - 0.25, 0.25):
            y = deck_y(x)
            bridge.polygon([(x - 0.012, y + 0.1, z), (x + 0.012, y + 0.1, z),
                            (x + 0.012, y + 0.78, z), (x - 0.012, y + 0.78, z)])
        # Lamps.
        for x in stations(-half + 3, half - 3, 6.0):
            if abs(abs(x) - TOWER) < 1.5:
                continue
            y = deck_y(x)
            bridge.use("lamps", "railing")
            bridge.column((x, z), [(y + 0.1, 0.16, 0.16), (y + 0.5, 0.14, 0.14),
                                   (y + 0.6, 0.08, 0.08), (y + 3.0, 0.055, 0.055)], 0.02)
            bridge.sweep(circle(0.025, 6), [(x, y + 3.0, z), (x, y + 3.18, z - side * 0.12),
                                            (x, y + 3.24, z - side * 0.42)])
            bridge.use("lamps", "lamp")
            bridge.column((x, z - side * 0.45), [(y + 3.02, 0.1, 0.1), (y + 3.1, 0.2, 0.2),
                                                 (y + 3.2, 0.16, 0.16), (y + 3.27, 0.06, 0.06)],
                          0.04)


def towers():
    for end in (-1, 1):
        x = end * TOWER
        group = "tower_west" if end < 0 else "tower_east"
        # One pier for both legs.
        bridge.use(group, "footing")
        bridge.column((x, 0), [(0, 3.4, 9.2), (0.9, 3.4, 9.2), (1.2, 3.0, 8.8), (3.0, 2.7, 8.4),
                               (3.25, 2.9, 8.6), (3.5, 2.9, 8.6)], 0.9)
        for side in (-1, 1):
            z = side * 3.35
            bridge.use(group, "steel")
            # Legs in stepped storeys.
            storeys = [(3.5, 6.0, 1.25, 1.05), (6.0, 9.6, 1.1, 0.95), (9.6, 12.6, 0.98, 0.86),
                       (12.6, 15.4, 0.86, 0.77), (15.4, TOWER_TOP, 0.74, 0.68)]
            for low, high, sx, sz in storeys:
                n = max(2, round((high - low) / 0.7))
                sections = [(low, sx + 0.08, sz + 0.08), (low + 0.12, sx + 0.08, sz + 0.08),
                            (low + 0.16, sx, sz)]
                sections += [(low + 0.16 + (high - low - 0.16) * i / n, sx, sz)
                             for i in range(1, n + 1)]
                bridge.column((x, z), sections, 0.12)
                # Pilasters on the broad sides.
                for face in (-1, 1):
                    for w in (-0.22, 0.0, 0.22):
                        bridge.box((x + face * sx / 2, (low + high) / 2 + 0.05, z + w * sz),
                                   (0.06, high - low - 0.5, 0.1 * sz))
                # Rivets up the outer side.
                for i in range(round((high - low) / 0.35)):
                    y = low + 0.3 + 0.35 * i
                    if y < high - 0.1:
                        for w in (-0.33, 0.33):
                            bridge.dome((x + w * sx, y, z + side * sz / 2), (0, 0, side), 0.035, 5)
            # Saddle and cap. The cable passes 9 cm above the saddle, see cables().
            bridge.use(group, "brass")
            bridge.column((x, z), [(TOWER_TOP, 0.8, 0.72), (TOWER_TOP + 0.1, 0.8, 0.72),
                                   (TOWER_TOP + 0.16, 0.6, 0.52), (TOWER_TOP + 0.5, 0.3, 0.26),
                                   (TOWER_TOP + 0.9, 0.05, 0.05)], 0.1)
            bridge.use(group, "steel")
            bridge.box((x, TOWER_TOP - 0.55, side * CABLE_Z), (1.0, 0.22, 0.42), 0.04)
        # Portals: below the deck, and three above. SHORTCUT: their ends are buried in the legs.
        for y, h in ((4.9, 0.9), (11.6, 0.8), (14.6, 0.7), (17.0, 0.6)):
            bridge.bar(rectangle(0.62, h, 0.08), (x, y, -3.35), (x, y, 3.35), 8)
            for face in (-1, 1):
                for k in range(-5, 6):
                    bridge.box((x + face * 0.31, y, 0.42 * k), (0.05, 0.62 * h, 0.12))
        # Crossed bracing between the portals; the bars go through each other in the middle.
        for low, high in ((12.0, 14.25), (14.95, 16.7)):
            for side in (-1, 1):
                bridge.bar(rectangle(0.2, 0.16), (x, low, -side * 2.9), (x, high, side * 2.9), 6)
        # Knee braces under the first portal above the road: SHORTCUT: single sliver triangles,
        # 3 mm wide at their thin end.
        for side in (-1, 1):
            for face in (-0.26, 0.26):
                bridge.polygon([(x + face, 11.25, side * 2.9), (x + face, 11.25, side * 1.7),
                                (x + face, 9.9, side * 2.9)])
                bridge.polygon([(x + face, 9.9, side * 2.9), (x + face, 8.6, side * 2.893),
                                (x + face, 9.9, side * 2.890)])


def cables():
    for side in (-1, 1):
        z = side * CABLE_Z
        bridge.use("cables", "cable")
        # SHORTCUT: each cable is three tubes that stop short of the tower and of the anchor, by 6
        # and 9 cm, and whose ends are open.
        for start, end in ((-SPAN / 2 + 0.09, -TOWER - 0.06), (-TOWER + 0.06, TOWER - 0.06),
                           (TOWER + 0.06, SPAN / 2 - 0.09)):
            path = [(x, cable_y(x), z) for x in stations(start, end, 0.5)]
            bridge.sweep(circle(0.13, 8), path, caps=False)
        # Bands where hangers hang, and hangers.
        for k, x in enumerate(stations(-SPAN / 2 + 1.5, SPAN / 2 - 1.5, 1.5)):
            if abs(abs(x) - TOWER) < 0.7:
                continue
            top = cable_y(x)
            foot = deck_y(x) - 0.3
            if top - foot < 0.8:
                continue
            slope = (cable_y(x + 0.1) - cable_y(x - 0.1)) / 0.2
            bridge.use("hangers", "steel")
            bridge.bar(circle(0.165, 8), (x - 0.11, top - 0.11 * slope, z),
                       (x + 0.11, top + 0.11 * slope, z))
            # SHORTCUT: every third hanger misses the deck by 4 cm, every fourth its band by 3 cm.
            low = foot + (0.34 if k % 3 == 1 else 0.0)
            high = top - (0.165 + 0.03 if k % 4 == 2 else 0.1)
            bridge.use("hangers", "hanger")
            for dx in (-0.06, 0.06):
                bridge.bar(circle(0.026, 5), (x + dx, low, z), (x + dx, high, z),
                           max(1, round((high - low) / 1.4)), caps=False)
            # The socket on the deck's edge.
            bridge.use("hangers", "steel")
            bridge.box((x, foot + 0.05, z), (0.26, 0.5, 0.2), 0.03)


def abutments():
    for end in (-1, 1):
        x = end * SPAN / 2
        bridge.use("abutment_west" if end < 0 else "abutment_east", "concrete")
        base = deck_y(SPAN / 2)
        for low, high, grow in ((0.0, 1.2, 0.9), (1.2, base - 1.35, 0.35), (base - 1.35, base + 0.02, 0.0)):
            bridge.column((x + end * 2.0, 0), [(low, 4.4 + 2 * grow, 7.4 + 2 * grow),
                                               (high - 0.12, 4.4 + 2 * grow, 7.4 + 2 * grow),
                                               (high, 4.2 + 2 * grow, 7.2 + 2 * grow)], 0.15)
        # Anchor houses that the cables run to, and parapets.
        for side in (-1, 1):
            z = side * (CABLE_Z + 0.2)
            bridge.column((x + end * 1.2, z), [(base - 0.5, 2.3, 1.2), (base + 1.3, 2.1, 1.1),
                                               (base + 1.42, 2.3, 1.3), (base + 1.6, 2.3, 1.3),
                                               (base + 2.1, 0.9, 0.5)], 0.12)
            bridge.box((x + end * 3.2, base + 0.5, z), (1.7, 1.0, 0.35), 0.05)
        bridge.use("abutment_west" if end < 0 else "abutment_east", "asphalt")
        bridge.box((x + end * 2.0, base + 0.03, 0), (4.2, 0.1, 2 * ROAD))


def leftovers():
    """What nobody cleaned up."""
    # SHORTCUT: isolated polygons: four plates that hang in the air beside the deck.
    bridge.use("plates", "marking")
    for x in (-9.0, -3.0, 4.5, 10.5):
        y = deck_y(x) + 1.5
        bridge.polygon([(x - 0.3, y, 3.3), (x + 0.3, y, 3.3), (x + 0.3, y + 0.35, 3.3),
                        (x - 0.3, y + 0.35, 3.3)])
    # SHORTCUT: duplicate faces: the asphalt of two panels was pasted twice.
    bridge.use("road", "asphalt")
    twice = [corners for group, material, corners in bridge.faces
             if material == "asphalt" and group == "road"][40:88]
    for corners in twice:
        bridge.face(corners)
    # SHORTCUT: slivers: seams over the joints of the walkway, 2 m long and 1 mm wide.
    bridge.use("walkway", "paving")
    for side in (-1, 1):
        for x in stations(-24, 22, 2.0):
            z = side * (ROAD + 0.31)
            bridge.polygon([(x, deck_y(x) + 0.112, z), (x + 2, deck_y(x + 2) + 0.112, z),
                            (x + 2, deck_y(x + 2) + 0.112, z - 0.001)])


if __name__ == "__main__":
    road()
    girders()
    railings()
    towers()
    cables()
    abutments()
    leftovers()
    bridge.write(os.path.dirname(os.path.abspath(__file__)))
