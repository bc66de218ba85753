"""Python's search for garbage in circles, put off while the program starts.

Loading modules makes hundreds of thousands of objects that stay: to look through them again and
again takes a tenth of the start, and a third of a second at once later, and finds nothing.
"""

import gc


def put_off() -> None:
    """Look for no garbage until `take_up`."""
    gc.disable()


def take_up() -> None:
    """Look for garbage from now on, but not among what is there already."""
    gc.freeze()
    gc.enable()


def look_at_all() -> None:
    """Look among everything from now on: what was there may have shown patients."""
    gc.unfreeze()
