"""All sentences on simulators: a template of each kind, filled from records last.

Nothing decides by a template: state, advice, sheet and page look at kinds, values and numbers.
"""

from __future__ import annotations

from msvalidate.problem.records import dataclass
from msvalidate_check import causes
from msvalidate_check.causes import say

SENTENCES = {
    "": "",
    "and": "; ",
    # Law and masses.
    "refused": "law: {refusals}",
    "no solid": "law: no solid at rest; {because}",
    "bound": "law: uniform strain pulls at inner nodes, so it is of no one solid",
    "law": "law: E {times:.4g} times the asked, nu {nu:.4g} for {given:g}{near}{over}",
    "near law": ": as {name} (--law {key})",
    "over density": ": as E over the density; then divide forces by it too",
    "documents": "law: read as E {E:.4g} Pa, nu {nu:.4g}; its documents say {said_E:.4g} Pa, "
    "{said_nu:.4g}",
    "large strain": "law: at {strain:.2g} strain {apart:.2g} of the displacement from elements of "
    "its documented law",
    "masses": "mass: {pattern}; {spread}",
    "mass matrix": "{pattern}; a mass matrix is taken as said, if its row sums are",
    "measured masses": "{pattern}; stress is read with the measured ones, and E over density is "
    "seen",
    "spread": "a node has {least:.2g} to {most:.2g} times its share",
    "pattern": "{name}",
    "pattern but": "{name}, but {nodes}{more}",
    "more nodes": " and {count} more",
    "no pattern": "no known pattern",
    "mass line": "masses: {pattern}{spread} (known to {error:.1e}; the total is asked, only ratios "
    "are observed)",
    "spread besides": "; {spread}",
    "no masses": "masses: not observed, as it told forces",
    # A reading that does not count, and moduli that are not there.
    "flag": "{name} {value:.1e}",
    "flag not asked": "{name} not asked",
    "not known": "C known to {part:.1e} of its largest component, {needed:g} is needed",
    "upper bound": "an upper bound alone: inner nodes are not at rest",
    "known of it": "{name} is known to {error:.1e}{of} only, and {needed:g} is needed",
    "of it": " of it",
    "vanishes": "the {name} modulus vanishes: {value:.3g} Pa, known to {error:.1g} Pa",
    "negative": "the {name} modulus is negative: {value:.6g} Pa, known to {error:.1g} Pa",
    "singular": "C is singular or not stable: its lowest eigenvalue {sign}, {value:.3g} Pa",
    "is negative": "is negative",
    "is zero": "vanishes",
    "flag line": "does not count: {flag}, at most {limit:.1e}: {because}",
    "no moduli": "no E and nu: {because}",
    "anisotropy": "anisotropy {part:.1e}: E and nu are of the isotropic part alone",
    "no reading": "no step was read: the law is told from bodies at rest alone",
    # Bodies at rest.
    "factor": "{name}: {times:.4g} times the displacement",
    "moving": "solver: run longer: {part} of a displacement may still change",
    "percent": "{percent:.0f} %",
    "all": "all",
    "rounded": "solver: positions in float32, {apart:.2g} of the displacement of {case} on {mesh}, "
    "{loaded:.2g} under {times:g} times the loads",
    "no bodies": "bodies at rest: it could represent none of them",
    "no law": "{case} on {mesh}: no law to hold it against",
    "one way": "{case} on {mesh}: {even:.2g} of the displacement goes one way, whatever the loads",
    "unexplained": "{case} on {mesh}: {apart:.2g} of the displacement not explained{shape}",
    "shape": ": {cause}",
    "large line": "{case} at {strain:.1%} strain: {apart:.2%} from elements of its documented law, "
    "which are {linear:.2%} from linear ones",
    # The gate, and questions.
    "gate": "{row}: {value:.2g} {unit}, at most {limit:.2g}; {because}",
    "gate failed": "{row}: {because}",
    "nothing passed": "nothing passed",
    "failure": "{question}: {why}",
    "note": "{what}: {why}",
    # The first words.
    "no answer": "no answer to {failures} of {count} questions{some}",
    "stopped": "stopped at the gate{some}",
    "nothing": "nothing could be tried{some}",
    "gate alone": "passes the gate; nothing else was asked",
    "its mesh": "the law agrees; {percent:.0f} % of the {body} is its mesh{some}",
    "state": "{state}{some}",
    "some": ", of {parts} alone",
    "who": "{who}; {count} questions",
    "silent": "it says nothing of itself",
    # What to do next.
    "ended": "give it longer by --limit, or mend what hangs; the rest was left out",
    "failed": "mend what it says; what it has no way to do, it ends with exit code 77 and a reason",
    "run longer": "run it longer (more iterations or steps, a smaller dt or stop) until at_rest is "
    "< 1 %",
    "ask the rest": "`adapter check ADAPTER --only {rest}` asks the rest",
    "own body": "`simulate CASE --with ADAPTER` judges a body of your own",
    "answer a task": "answer one of the two tasks, rest or motion, on a mesh of tetrahedra",
    "settle": "{row}: try {settings}, until twice as many change nothing; and state in at_rest how "
    "far it is from that",
    "or": "{one} or {other}",
    "set": "--set {name}={value:.4g}",
    "falls up": "free fall: it falls up: turn the sign of gravity",
    "mend row": "{row}: mend it first: no number counts before that",
    "rest stays at rest": "{row}: in a motion let nothing but the body's own forces act: no "
    "damping, contact, floor or support",
    "free fall": "{row}: take gravity from request.json at each question, switch damping off, and "
    "say in solves_to what the solve of a step leaves",
    "small turn": "{row}: hold no node in a motion, and ask for double precision where there is "
    "one",
    "twice the modulus": "{row}: hand on E of request.json at each question; where loads move too "
    "much for small strain, divide forces by the density too if E is, or see the units",
    "the same again": "{row}: start each question from nothing, and make sums in one order",
    "give masses": "give it the masses of nodal.csv, or say in its documents whose masses it takes",
    "see source": "see how its source takes E and nu; a documented law is named by --law "
    "(`adapter laws`)",
    "say so": "it is the law that its documents have, and not the E and nu that it is asked for: "
    "say so",
    "see flag": "see {name}: {because}",
    "double": "take double precision, if it has any",
    "name another": "see how its source takes E and nu, or name another law of `adapter laws`",
    "answer rest": "answer the task rest too; `--only gate --only probe` judges the law alone",
    "answer motion": "answer motion of one step too, or name its law by --law, so that law is told "
    "from rest",
    "whole body": "`simulate CASE --with ADAPTER` shows one body whole: where it differs, and how",
}
"""Key of a phrase -> template."""


@dataclass(frozen=True)
class Cause(causes.Cause):
    """Why a simulator differs, or what to do next: a kind, and what its sentence names."""

    @property
    def said(self) -> str:
        """As a sentence."""
        return say(self.of, SENTENCES)


def text_of(of: object) -> str:
    """A phrase, or several, as text; a text as it is."""
    return say(of, SENTENCES)
