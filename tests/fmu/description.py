"""The rules of the standard for modelDescription.xml, as checks (FMI 2.0.4, sections 2.2 and 3.3, 4.3; FMI 3.0, 2.4).
SPDX-License-Identifier: BSD-3-Clause"""
import re
import xml.etree.ElementTree as xml

IDENTIFIER = r"[A-Za-z_]\w*"
QUOTED = r"'(?:[^'\\\"]|\\['\\])+'"
NAME = re.compile(rf"^(?:der\()?(?:{IDENTIFIER}|{QUOTED})(?:\[\d+(?:,\d+)*\])?"
                  rf"(?:\.(?:{IDENTIFIER}|{QUOTED})(?:\[\d+(?:,\d+)*\])?)*\)?$", re.ASCII)


class Variable:
    def __init__(self, element, real):
        get = element.get
        self.name, self.causality = get("name"), get("causality", "local")
        self.variability, self.initial = get("variability", "continuous"), get("initial")
        self.reference = int(get("valueReference"))
        self.unit, self.start = real.get("unit"), real.get("start")
        self.display = real.get("displayUnit")
        self.min, self.max = real.get("min"), real.get("max")
        self.derivative = real.get("derivative")


class Description:
    """What an importer reads; `errors` lists every rule that is broken."""

    def __init__(self, text):
        self.errors = []
        self.root = root = xml.fromstring(text)
        self.version = root.get("fmiVersion")
        self.two = self.version == "2.0"
        self.token = root.get("guid" if self.two else "instantiationToken")
        self.kinds = {name: root.find(name) for name in ("ModelExchange", "CoSimulation")
                      if root.find(name) is not None}
        elements = list(root.find("ModelVariables"))
        self.variables = [Variable(e, e.find("Real") if self.two else e) for e in elements]
        self.by_name = {v.name: v for v in self.variables}
        self.by_reference = {v.reference: v for v in self.variables}
        self.outputs = [v for v in self.variables if v.causality == "output"]
        self.inputs = [v for v in self.variables if v.causality == "input"]
        self.parameters = [v for v in self.variables if v.causality == "parameter"]
        self.derivatives = [v for v in self.variables if v.derivative is not None]
        self.states = [self.state_of(v) for v in self.derivatives]
        self.indicators = (int(root.get("numberOfEventIndicators", 0)) if self.two else
                           len(root.findall("ModelStructure/EventIndicator")))
        self.check()

    def state_of(self, v):
        number = int(v.derivative)
        return self.variables[number - 1] if self.two else self.by_reference[number]

    def need(self, good, text):
        if not good:
            self.errors.append(text)

    def check(self):
        root, need = self.root, self.need
        need(root.tag == "fmiModelDescription", "the root element")
        need(self.version in ("2.0", "3.0"), "fmiVersion")
        need(self.token and root.get("modelName"), "token and name of the model")
        need(self.kinds, "neither model exchange nor co-simulation")
        for kind in self.kinds.values():
            need(re.match(rf"^{IDENTIFIER}$", kind.get("modelIdentifier", "")), "modelIdentifier")
        order = [e.tag for e in root]
        right = ["ModelExchange", "CoSimulation", "UnitDefinitions", "LogCategories",
                 "DefaultExperiment", "ModelVariables", "ModelStructure"]
        need(order == [tag for tag in right if tag in order], f"order of elements {order}")
        need(len(self.by_name) == len(self.variables), "names are not unique")
        need(len(self.by_reference) == len(self.variables), "value references are not unique")
        units = {u.get("name"): {x.get("name") for x in u.findall("DisplayUnit")}
                 for u in root.findall("UnitDefinitions/Unit")}
        for v in self.variables:
            self.check_variable(v, units)
        need(sum(v.causality == "independent" for v in self.variables) == 1, "independent variable")
        categories = [c.get("name") for c in root.findall("LogCategories/Category")]
        need(len(categories) == len(set(categories)) > 0, "log categories")
        self.check_structure()

    def check_variable(self, v, units):
        need = self.need
        need(root_name(v.name), f"{v.name}: not a structured name")
        need(v.unit is None or v.unit in units, f"{v.name}: unit {v.unit} is not defined")
        need(v.display is None or v.display in units.get(v.unit, ()), f"{v.name}: {v.display}")
        has = {"parameter": "exact", "input": None, "independent": None}
        if v.causality in has:
            need(v.initial in (has[v.causality], None), f"{v.name}: initial {v.initial}")
        need((v.start is not None) == (v.causality in ("parameter", "input") or
                                       v.initial in ("exact", "approx")), f"{v.name}: start")
        need(v.variability == ("fixed" if v.causality == "parameter" else "continuous"),
             f"{v.name}: {v.causality} that is {v.variability}")
        if v.start is not None:
            start = float(v.start)
            need(v.min is None or float(v.min) <= start, f"{v.name}: start below min")
            need(v.max is None or float(v.max) >= start, f"{v.name}: start above max")
        if v.derivative is not None:
            state = self.state_of(v)
            need(state.variability == "continuous" and state.causality in ("local", "output"),
                 f"{v.name}: derivative of {state.name}")

    def structure(self, two, three):
        """References of the unknowns of a list of the structure."""
        if self.two:
            unknowns = self.root.findall(f"ModelStructure/{two}/Unknown")
            return [self.variables[int(u.get("index")) - 1].reference for u in unknowns], unknowns
        unknowns = self.root.findall(f"ModelStructure/{three}")
        return [int(u.get("valueReference")) for u in unknowns], unknowns

    def check_structure(self):
        need = self.need
        outputs, elements = self.structure("Outputs", "Output")
        need(outputs == [v.reference for v in self.outputs], "outputs of the structure")
        derivatives, more = self.structure("Derivatives", "ContinuousStateDerivative")
        need(derivatives == [v.reference for v in self.derivatives], "derivatives")
        need(("ModelExchange" in self.kinds) == bool(derivatives), "model exchange without states")
        initial, rest = self.structure("InitialUnknowns", "InitialUnknown")
        states = {v.reference for v in self.states}
        right = [v.reference for v in self.variables
                 if v.initial in ("approx", "calculated") and
                 (v.causality == "output" or v.reference in states or v.derivative is not None)]
        need(initial == right, "initial unknowns")
        first = 1 if self.two else 0
        numbers = {k + first for k in range(len(self.variables))}
        for element in elements + more + rest:
            listed = element.get("dependencies")
            kinds = element.get("dependenciesKind")
            if listed is None:
                need(kinds is None, "kinds of dependencies without these")
                continue
            listed = [int(x) for x in listed.split()]
            need(set(listed) <= numbers and listed == sorted(listed), "dependencies")
            need(kinds is None or len(kinds.split()) == len(listed), "kinds of dependencies")


def root_name(name):
    return NAME.match(name) is not None
