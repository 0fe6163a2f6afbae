"""The one reader of history.csv: a line of names with units, `reaction_push_y [N]`, then a row of numbers for each step.

    import histories
    columns, units = histories.read("history.csv")
    columns["reaction_push_y"][-1], units["reaction_push_y"]
"""


def read(path):
    """Columns by bare name, each a list of numbers, and units by name ("" without). A last row that is not whole is left
    out, as a run may be writing it. Raises OSError, or ValueError with the place where the file is no history."""
    with open(path) as file:
        lines = [line for line in file if line.strip() and not line.startswith("#")]
    if not lines:
        raise ValueError(f"{path} has no header")
    heads = [head.partition(" [") for head in lines[0].strip().split(",")]
    names, units = [head[0] for head in heads], {head[0]: head[2].rstrip("]") for head in heads}
    if not lines[-1].endswith("\n") and len(lines) > 1:
        lines.pop()
    columns = {name: [] for name in names}
    for number, line in enumerate(lines[1:], start=1):
        cells = line.split(",")
        if len(cells) != len(names):
            raise ValueError(f"{path}: row {number} has {len(cells)} cells instead of {len(names)}")
        for name, cell in zip(names, cells):
            try:
                columns[name].append(float(cell))
            except ValueError:
                raise ValueError(f"{path}: row {number}, column {name}: {cell.strip()!r} is no number") from None
    return columns, units
