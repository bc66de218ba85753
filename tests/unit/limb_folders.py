"""Folders of small labelled images."""

import numpy as np

from adibas.limbs.training_set import FolderHeader, write_header, write_image

NAMES = ("torso", "left_hand")


def fill(folder, n_images=10, names=NAMES, first=0):
    """Trunks with one hand each, of two people in turn."""
    people = {f"{i:04d}": f"p{i % 2}" for i in range(n_images)}
    write_header(folder, FolderHeader(names, 0.001, 100.0, 100.0, 40.0, 30.0, people))
    for i in range(n_images):
        rng = np.random.default_rng(first + i)
        labels = np.zeros((60, 80), np.uint8)
        left = int(rng.integers(10, 50))
        labels[10:50, left : left + 14] = 1
        labels[20:28, left + 14 : left + 22] = 2
        depth = np.where(labels > 0, 2000 + rng.integers(-3, 4, labels.shape), 0)
        depth[labels == 2] -= 120
        write_image(folder, f"{i:04d}", depth.astype(np.uint16), labels)
    return folder
