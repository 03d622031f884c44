"""What a parameter of a model may be: its dimension and its rule, as an annotation of the model's function."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

from haptisym.model.parameters import Rule, Slot
from haptisym.model.quantities import Dimension

Mass: TypeAlias = Annotated[Any, Slot(Dimension.MASS, Rule.NONNEGATIVE)]
Damping: TypeAlias = Annotated[Any, Slot(Dimension.DAMPING, Rule.NONNEGATIVE)]
Stiffness: TypeAlias = Annotated[Any, Slot(Dimension.STIFFNESS, Rule.NONNEGATIVE)]
PositiveMass: TypeAlias = Annotated[Any, Slot(Dimension.MASS)]
PositiveDamping: TypeAlias = Annotated[Any, Slot(Dimension.DAMPING)]
PositiveStiffness: TypeAlias = Annotated[Any, Slot(Dimension.STIFFNESS)]
StiffnessList: TypeAlias = Annotated[Any, Slot(Dimension.STIFFNESS, several=True)]
DampingList: TypeAlias = Annotated[Any, Slot(Dimension.DAMPING, several=True)]
SignedMass: TypeAlias = Annotated[Any, Slot(Dimension.MASS, Rule.ANY)]
SignedDamping: TypeAlias = Annotated[Any, Slot(Dimension.DAMPING, Rule.ANY)]
SignedStiffness: TypeAlias = Annotated[Any, Slot(Dimension.STIFFNESS, Rule.ANY)]
Frequency: TypeAlias = Annotated[Any, Slot(Dimension.FREQUENCY)]
Time: TypeAlias = Annotated[Any, Slot(Dimension.TIME, Rule.NONNEGATIVE)]
PositiveTime: TypeAlias = Annotated[Any, Slot(Dimension.TIME)]
DampingRatio: TypeAlias = Annotated[Any, Slot(Dimension.RATIO, Rule.NONNEGATIVE)]
Order: TypeAlias = Annotated[Any, Slot(Dimension.RATIO, Rule.ORDER)]
Samples: TypeAlias = Annotated[Any, Slot(Dimension.RATIO, Rule.WHOLE)]
Method: TypeAlias = Annotated[
    Any, Slot(Dimension.ANY, Rule.ANY, choices=("backward-difference", "tustin", "forward-difference"))
]
FractionalOrder: TypeAlias = Annotated[Any, Slot(Dimension.RATIO, Rule.FRACTION)]
FractionalStiffness: TypeAlias = Annotated[Any, Slot(Dimension.ANY)]
Force: TypeAlias = Annotated[Any, Slot(Dimension.FORCE, Rule.NONNEGATIVE)]
Amplitude: TypeAlias = Annotated[Any, Slot(Dimension.DISPLACEMENT)]
Formula: TypeAlias = Annotated[Any, Slot(Dimension.ANY, Rule.ANY, formula=True)]
