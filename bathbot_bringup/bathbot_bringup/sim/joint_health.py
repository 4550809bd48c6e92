"""What healthy joints report of themselves, in the units of the wire; always the same here."""

CURRENT = [350] * 6  # [0.001 A]
VOLTAGE = [24000] * 6  # [0.001 V]
TEMPERATURE = [34000] * 6  # [0.001 deg C]
