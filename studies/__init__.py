"""One module per study; each has ``run(candidate, setting=…) -> Evidence`` and ``FAULTS``.

``FAULTS`` are the negative controls: name -> keyword arguments of ``run`` under which it must fail.
"""
