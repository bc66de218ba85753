"""A ray of the furnished room ends on the first thing that a walk along it comes into."""

import numpy as np

from adibas.simulation.furnished_room_kernels import cast_rays

ROOM = np.array([0.0, -1.3, 0.0, 2.4, 1.3, 2.4, 1.0, 0.0])
STEP_M = 0.001


def is_inside(place, box):
    c, s = box[6:]
    turn = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    return (np.abs(turn @ (place - box[:3])) < box[3:6]).all()


def walked(origin, way, boxes, spheres):
    """Return the distance and the owner that small steps along a way come to."""
    for k in range(1, 6000):
        place = origin + k * STEP_M * way
        if not is_inside(place, boxes[0]):
            return k * STEP_M, 0
        for number, box in enumerate(boxes[1:], 1):
            if is_inside(place, box):
                return k * STEP_M, number
        for number, sphere in enumerate(spheres, len(boxes)):
            if np.linalg.norm(place - sphere[:3]) < sphere[3]:
                return k * STEP_M, number
    raise AssertionError("the room has no wall there")


def test_rays_end_where_a_walk_along_them_ends():
    rng = np.random.default_rng(3)
    angle = 0.6
    boxes = np.array([ROOM, [0.8, -0.7, 0.9, 0.3, 0.5, 0.2, np.cos(angle), np.sin(angle)]])
    spheres = np.array([[-0.7, -1.0, 0.8, 0.4], [0.5, -1.2, 1.8, 0.3]])
    origin = np.array([0.1, -1.2, -0.8])
    ways = rng.normal([0.0, 0.0, 1.0], 0.4, (60, 3))
    ways[0], ways[1] = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    depths, owners = cast_rays(origin, ways, boxes, spheres)
    assert set(owners.tolist()) == {0, 1, 2, 3}
    for way, depth, owner in zip(ways, depths, owners, strict=True):
        far, whose = walked(origin, way, boxes, spheres)
        assert owner == whose
        assert far - STEP_M <= depth <= far + 1e-9
