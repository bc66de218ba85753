"""Python's search for garbage in circles, put off while the program starts.

Loading modules makes hundreds of thousands of objects that stay; looking through them again and
again takes a tenth of the start and finds nothing.
"""

import gc


def put_off() -> None:
    """Look for no garbage until `take_up`."""
    gc.disable()


def take_up() -> None:
    """Look for garbage from now on."""
    gc.enable()
