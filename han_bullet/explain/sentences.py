"""The layers' effects on the way, as sentences."""

from __future__ import annotations

import math

from han_bullet.explain.explanation import LayerEffect, WayExplained

# Shorter shifts are the grid's [m].
NOTICED = 0.05
BUILDING = ("static", "obstacle", "inflation")


def movers(way: WayExplained) -> list[LayerEffect]:
    """Return the layers that move or close the way, the strongest first."""
    return sorted((effect for effect in way.layers if strength(effect) >= NOTICED), key=strength, reverse=True)


def strength(effect: LayerEffect) -> float:
    """Return how far a layer moves the way [m]; infinite where there is a way only with it or only without it."""
    if effect.shift is not None:
        return abs(effect.shift.largest)
    return math.inf if math.isfinite(effect.cost_of_way) != math.isfinite(effect.cost_without) else 0.0


def verdict(way: WayExplained) -> list[str]:
    """Tell which layer moved the way most; where that is the building, also which of the others did."""
    strongest = movers(way)
    if not strongest:
        return ["no layer moved the way"]
    told = strongest[:1]
    if told[0].layer in BUILDING:
        told += [effect for effect in strongest if effect.layer not in BUILDING][:1]
    return [sentence(effect) for effect in told]


def sentence(effect: LayerEffect) -> str:
    """Tell what a layer did to the way."""
    because = _because(effect)
    if effect.shift is None:
        return f"{effect.layer} closed the way{because}: without it there is one of {effect.length:.1f} m"
    (x, y), far = effect.shift.place, abs(effect.shift.largest)
    side = "left" if effect.shift.largest > 0.0 else "right"
    return f"{effect.layer} moved the way by {far:.2f} m to the {side} near ({x:.1f}, {y:.1f}){because}"


def has_effect(effect: LayerEffect, way: WayExplained) -> bool:
    """Tell whether a layer moves the way, or makes it dearer."""
    return strength(effect) >= NOTICED or abs(way.best_cost - effect.cost_of_way) >= NOTICED


def details(effect: LayerEffect, way: WayExplained) -> str:
    """Tell everything of a layer's effect: how far, which costs, where, whose doing, and who is on which side."""
    told = [f"without it this way costs {effect.cost_of_way:.2f}"] if math.isfinite(effect.cost_of_way) else []
    if effect.shift is None or abs(effect.shift.largest) < NOTICED:
        told.insert(0, "there is a way only without it" if math.isinf(strength(effect)) else "does not move the way")
    else:
        side = "left" if effect.shift.largest > 0.0 else "right"
        told.insert(0, f"moves the way up to {abs(effect.shift.largest):.2f} m to the {side}")
        told[0] += f", {effect.shift.mean:.2f} m on average"
    if effect.way is not None and strength(effect) >= NOTICED:
        counted = f"costs {effect.cost_if_ignored:.2f}" if way.best is not None else "is closed"
        told.append(
            f"the best way without it is {effect.length:.2f} m long, costs {effect.cost_without:.2f}, and {counted} if "
            f"{effect.layer} counts"
        )
    if effect.dearest is not None:
        (x, y), rise = effect.dearest
        told.append(f"it adds most, {rise}, at ({x:.1f}, {y:.1f}){_because(effect)}")
    if effect.sides != way.sides:
        told.append(f"the best way without it has {sides_of(effect.sides) or 'nobody beside it'}")
    return "; ".join(told)


def sides_of(sides: dict[str, str]) -> str:
    """Tell who is on which side of a way."""
    return ", ".join(f"{name} on its {side}" for name, side in sides.items())


def _because(effect: LayerEffect) -> str:
    return f", because of {' and '.join(effect.causes)}" if effect.causes else ""
