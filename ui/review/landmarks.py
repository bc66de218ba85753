"""Names of landmarks that are suggested for markers."""

from adibas.texts import message
from adibas.texts import translate as _

RIGHT, LEFT = message("{landmark}, right"), message("{landmark}, left")
MIDDLE = (
    message("Glabella"),
    message("Menton"),
    message("Sternal notch"),
    *("C7", "T1", "T3", "T5", "T7", "T9", "T12", "L1", "L3", "L5", "S1"),
)
PAIRED = (
    message("Tragus"),
    message("Acromion"),
    message("Inferior angle of scapula"),
    message("Lateral epicondyle"),
    message("Wrist"),
    message("ASIS"),
    message("PSIS"),
    message("Greater trochanter"),
    message("Knee joint line"),
    message("Patella"),
    message("Tibial tuberosity"),
    message("Achilles tendon"),
    message("Calcaneus"),
    message("Lateral malleolus"),
    message("Medial malleolus"),
)


def landmark_names() -> tuple[str, ...]:
    """Return the names in the language in use, from head to foot; left is the patient's."""
    paired = (_(side).format(landmark=_(one)) for one in PAIRED for side in (RIGHT, LEFT))
    return (*(_(one) for one in MIDDLE), *paired)
