"""Charges on electrodes and slabs, and the actuators that they pull."""
