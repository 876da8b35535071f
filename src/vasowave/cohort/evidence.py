"""What the posteriors of the animals say of two wall laws: how much likelier each recording is under one of them."""

from typing import NamedTuple

import numpy as np

from vasowave.cohort.cohort import Cohort

CLEAR = 20.0
"""Ratio of two evidences from which one law is called clearly likelier: with equal chances before, 95 % after."""


class Evidence(NamedTuple):
    """One wall law against another by the evidences of both.

    Attributes
    ----------
    wall : str
    ratios : dict of str to float
        By animal: how many times as likely its recording is under the reference law as under `wall`, all that is
        unknown integrated out.
    untrusted : list of str
        Animals one of whose posteriors cannot be trusted; they are not among the ratios.
    """

    wall: str
    ratios: dict[str, float]
    untrusted: list[str]

    @property
    def clear(self) -> tuple[int, int]:
        """Number of animals for which the reference is clearly likelier, and for which `wall` is."""
        values = np.array(list(self.ratios.values()))
        return int((values >= CLEAR).sum()), int((values <= 1 / CLEAR).sum())

    @property
    def side(self) -> int:
        """1 where the animals together speak for the reference, -1 for `wall`, 0 for neither.

        They do where some animal does clearly, none clearly against it, and the product of all ratios is clear. Small
        ratios of many animals alone decide nothing: an image that the animals share moves all of them alike.
        """
        together = float(np.sum(np.log(list(self.ratios.values()))))
        sign = 0 if abs(together) < np.log(CLEAR) else int(np.sign(together))
        favorable, contrary = self.clear[::sign] if sign else (0, 0)
        return sign if favorable and not contrary else 0


def evidences(cohort: Cohort, reference: str) -> list[Evidence]:
    """Return what the stored comparisons of posteriors say of `reference` against each other law; none without them."""
    found: dict[str, Evidence] = {}
    for result in cohort.results:
        if result.evidence is None:
            continue
        logs = result.evidence["log_evidence"].to_series()
        if reference not in logs:
            continue
        posteriors = {wall: result.laws[wall].posterior for wall in logs.index}
        trusted = {wall: one is not None and one.trusted for wall, one in posteriors.items()}
        for wall in (one for one in logs.index if one != reference):
            one = found.setdefault(wall, Evidence(wall, {}, []))
            if trusted[wall] and trusted[reference]:
                one.ratios[result.name] = float(np.exp(np.clip(logs[reference] - logs[wall], -700, 700)))
            else:
                one.untrusted.append(result.name)
    return list(found.values())
