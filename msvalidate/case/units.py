"""Names of units, and what each is in SI units."""

LENGTH = {
    "m": 1.0,
    "km": 1e3,
    "cm": 1e-2,
    "mm": 1e-3,
    "um": 1e-6,
    "µm": 1e-6,
    "nm": 1e-9,
    "in": 0.0254,
    "ft": 0.3048,
}
PRESSURE = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9}
DENSITY = {"kg/m3": 1.0, "kg/m³": 1.0, "g/cm3": 1e3}
STIFFNESS = {"N/m": 1.0, "N/mm": 1e3, "kN/m": 1e3}
