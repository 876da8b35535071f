"""One-to-one matching of two trees by topology, then by size."""

from itertools import permutations

import numpy as np

from vasowave.pulse.network.network import Network


def match(first: Network, second: Network) -> dict[int, int]:
    """Return rows of `first` to rows of `second`, from the roots down; vessels left out have no counterpart.

    Among all ways to pair the daughters of matched vessels the one that pairs the most vessels counts, and among
    these the one with the least sum of log ratios of lengths and radii, in size: squares would let one wrong length
    decide about all. Up to six daughters a vessel.
    """
    size_a, size_b = np.log([first.length, first.radius]), np.log([second.length, second.radius])
    memo: dict[tuple[int, int], tuple[int, float, dict[int, int]]] = {}

    def best(a: int, b: int) -> tuple[int, float, dict[int, int]]:
        if (a, b) not in memo:
            cost = float(np.abs(size_a[:, a] - size_b[:, b]).sum())
            fewer, candidates = first.daughters[a], second.daughters[b]
            swap = len(fewer) > len(candidates)
            if swap:
                fewer, candidates = candidates, fewer
            options = []
            for chosen in permutations(candidates, len(fewer)):
                pairs = [best(y, x) if swap else best(x, y) for x, y in zip(fewer, chosen, strict=True)]
                merged = {a: b}
                for pair in pairs:
                    merged |= pair[2]
                options.append((len(merged), cost + sum(pair[1] for pair in pairs), merged))
            memo[a, b] = max(options, key=lambda option: (option[0], -option[1]))
        return memo[a, b]

    # Deepest pairs first, so that the recursion above never goes deeper than one level.
    for rows_a, rows_b in reversed(list(zip(first.generations, second.generations, strict=False))):
        for a in rows_a:
            for b in rows_b:
                best(int(a), int(b))
    return best(first.root, second.root)[2]


def unmatched(first: Network, second: Network, pairs: dict[int, int]) -> tuple[list[str], list[str]]:
    """Return the names of the vessels of each network that `pairs` (see `match`) leaves out."""
    matched_rows = set(pairs.values())
    return (
        [name for row, name in enumerate(first.name) if row not in pairs],
        [name for row, name in enumerate(second.name) if row not in matched_rows],
    )
