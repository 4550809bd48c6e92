"""The six skin classes of section 2.1.1.1, in the order of their ids, and the paper's seventh."""

SKIN_CLASSES: tuple[str, ...] = (
    "Face_skin",
    "Trunk_skin",
    "Upperlimb_skin",
    "Lowerlimb_skin",
    "Hand_skin",
    "Foot_skin",
)
"""Class names; the index is the class id, as in the model's output and in LabelInfo."""

BACKGROUND = "Background"
"""The paper's seventh category: a label (id 6) for what is no skin. It is never detected."""

LABELS: tuple[str, ...] = (*SKIN_CLASSES, BACKGROUND)
"""Every label a data set may use, ids 0 to 6."""
