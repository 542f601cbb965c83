"""The product tree of the kernel's XCAF document: every use of every leaf, with its place, name, colour and layers."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from OCP.TopLoc import TopLoc_Location
from OCP.XCAFDoc import XCAFDoc_DocumentTool, XCAFDoc_LayerTool, XCAFDoc_ShapeTool

from cad.kernel.call import KernelObject
from cad.kernel.xcaf import label_color, label_entry, label_name, labels_of, new_label
from wpcal.brep.mesh import Rgb

EMPTY_NAMES = frozenset({"", "NONE", "NULL"})
"""Names that exporters write when there is no name (SolidWorks writes 'NONE' on every face and edge)."""


def usable_name(name: str) -> str:
    """A name on one line without blanks at its ends; empty for `EMPTY_NAMES`."""
    line = " ".join(name.split())
    return "" if line.upper() in EMPTY_NAMES else line


def merged_layers(layers: tuple[str, ...], more: tuple[str, ...]) -> tuple[str, ...]:
    """Layers of both, each once, in order."""
    return tuple(dict.fromkeys((*layers, *more)))


@dataclass(frozen=True, slots=True)
class Use:
    """One use of a product: its place, and the attributes of the instances above it."""

    location: Any  #: Of the product in the frame `part`.
    path: tuple[str, ...] = ()  #: Names of the instances from the root down.
    products: tuple[str, ...] = ()  #: Names of the products from the root down.
    name: str = ""  #: Name of the nearest product above that has one.
    color: Rgb | None = None  #: Colour of the highest instance above that has one. It overrides the product's own.
    layers: tuple[str, ...] = ()  #: Layers of the instances above.


@dataclass(frozen=True, slots=True)
class Leaf:
    """One use of a product without components."""

    entry: str  #: Address of the product in the document, the same for all its uses.
    label: Any  #: Of the product.
    shape: Any  #: In the product's own frame, mm.
    use: Use  #: Its place, with the product's own name, colour and layers merged in.


@dataclass(slots=True)
class StepTree:
    """The labels of a document, and the layers of each label."""

    document: Any
    layers: dict[str, tuple[str, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        tool = XCAFDoc_DocumentTool.LayerTool_s(self.document.Main())
        for layer in labels_of(tool.GetLayerLabels):
            for label in labels_of(XCAFDoc_LayerTool.GetShapesOfLayer_s, layer):
                entry = label_entry(label)
                self.layers[entry] = merged_layers(self.layers.get(entry, ()), (label_name(layer),))

    def layers_of(self, label: KernelObject) -> tuple[str, ...]:
        """Layers of a label, in the order of the document."""
        return self.layers.get(label_entry(label), ()) if self.layers else ()

    def leaves(self) -> Iterator[Leaf]:
        """All uses of all leaves, in the order of the file."""
        tool = XCAFDoc_DocumentTool.ShapeTool_s(self.document.Main())
        for root in labels_of(tool.GetFreeShapes):
            yield from self._below(root, Use(TopLoc_Location()))

    def _below(self, label: KernelObject, use: Use) -> Iterator[Leaf]:
        """Leaves below a label."""
        use = self._joined(use, label)
        use = replace(use, path=use.path or ((use.name,) if use.name else ()))
        if not XCAFDoc_ShapeTool.IsAssembly_s(label):
            yield Leaf(label_entry(label), label, XCAFDoc_ShapeTool.GetShape_s(label), use)
            return
        for component in labels_of(XCAFDoc_ShapeTool.GetComponents_s, label):
            product = new_label()
            if XCAFDoc_ShapeTool.GetReferredShape_s(component, product):
                yield from self._below(product, self._component(use, component, product))

    def _component(self, use: Use, component: KernelObject, product: KernelObject) -> Use:
        """Use of a component's product: placed by the component, and named by it in the path."""
        step = usable_name(label_name(component)) or usable_name(label_name(product))
        return replace(
            use,
            location=use.location.Multiplied(XCAFDoc_ShapeTool.GetLocation_s(component)),
            path=(*use.path, step) if step else use.path,
            color=use.color or label_color(component),
            layers=merged_layers(use.layers, self.layers_of(component)),
        )

    def _joined(self, use: Use, label: KernelObject) -> Use:
        """Use with the product's own name, colour and layers."""
        own = usable_name(label_name(label))
        return replace(
            use,
            products=(*use.products, own) if own else use.products,
            name=own or use.name,
            color=use.color or label_color(label),
            layers=merged_layers(use.layers, self.layers_of(label)),
        )
