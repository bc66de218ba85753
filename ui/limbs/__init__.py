"""The editor of labelled images: limbs painted over the depth of a recording."""
