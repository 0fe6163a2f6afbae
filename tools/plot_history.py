#!/usr/bin/env python3
"""Draw force, energies, damage and hardening of a history file over time, or over another column.

    tools/plot_history.py run/history.csv run/history.png --force reaction
"""
import argparse
import os
import sys

import histories
import numpy as np

# Colours that differ for colour-blind readers too (Okabe and Ito).
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999"]
ENERGIES = ["energy_kinetic", "energy_elastic", "energy_plastic", "energy_fracture", "energy_thermal",
            "energy_contact", "dissipated_viscous", "dissipated_damage", "dissipated_plastic",
            "dissipated_friction", "dissipated_fatigue", "dissipated_contact", "dissipated_closing", "dissipated_numerical",
            "work_external", "heat_supplied"]


def stop(message):
    print(f"plot_history.py: {message}", file=sys.stderr)
    sys.exit(2)


def read(path):
    """Columns by name, as arrays, and their units."""
    try:
        columns, units = histories.read(path)
    except (OSError, ValueError) as error:
        stop(f"cannot read {path}: {error}" if isinstance(error, (OSError, UnicodeDecodeError)) else error)
    if not columns.get("time"):
        stop(f"{path} has no rows yet" if "time" in columns else f"{path} is no history file: it has no column `time`")
    return {name: np.array(values) for name, values in columns.items()}, units


def moves(values):
    """Whether a column has anything to show."""
    finite = values[np.isfinite(values)]
    return finite.size > 0 and np.any(finite != 0)


def force_columns(data, prefix):
    if prefix:
        names = [n for n in data if n.startswith(prefix)]
        if not names:
            stop(f"no column begins with {prefix}; forces there are: "
                 + (", ".join(force_columns(data, None)) or "none"))
        return names
    return [n for n in data if n.startswith("reaction_")
            or (n.startswith("contact_") and n.rsplit("_", 1)[0].endswith("_force"))]


def strongest(data, names, limit):
    """The columns with the largest values, in their own order; round-off beside them is left out."""
    size = {n: np.nanmax(np.abs(data[n])) for n in names if moves(data[n])}
    if not size:
        return []
    top = max(size.values())
    kept = sorted((n for n in size if size[n] > 1e-6 * top), key=lambda n: -size[n])[:limit]
    return [n for n in names if n in kept]


def readable(name):
    return name.replace("_", " ")


def draw_lines(axis, data, over, names, title, ylabel):
    for k, name in enumerate(names):
        axis.plot(data[over], data[name], lw=1.3, color=COLOURS[k % len(COLOURS)],
                  ls=["-", "--", ":"][k // len(COLOURS) % 3], label=readable(name))
    axis.set_title(title, loc="left")
    axis.set_ylabel(ylabel)
    if names:
        axis.legend(frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    else:
        axis.text(0.5, 0.5, "all zero or absent", ha="center", va="center", transform=axis.transAxes, color="0.5")


def unit_of(units, names):
    """The unit that columns share, in brackets."""
    return next((f" ({units[name]})" for name in names if units[name]), "")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("history")
    parser.add_argument("figure", help="its ending gives the kind of file: .png, .pdf, .svg")
    parser.add_argument("--force", metavar="PREFIX", help="draw the columns that begin so, forces or measures (default: all forces)")
    parser.add_argument("--over", metavar="COLUMN", default="time", help="what is drawn to the right (default: time)")
    parser.add_argument("--title")
    options = parser.parse_args()
    data, units = read(options.history)
    over = options.over
    if over not in data:
        stop(f"no column {over}")

    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    plt.rcParams.update({"font.size": 9, "axes.titlesize": 9.5, "axes.spines.top": False, "axes.spines.right": False,
                         "legend.fontsize": 7.5, "axes.formatter.limits": (-3, 4), "axes.formatter.use_mathtext": True})
    fields = [n for n in ("phi_max", "alpha_max") if n in data and moves(data[n])]
    figure, axes = plt.subplots(3 if fields else 2, 1, figsize=(7.2, 7.0 if fields else 4.9), sharex=True)
    forces, energies = force_columns(data, options.force), [n for n in ENERGIES if n in data]
    what = readable(options.force) if (options.force or "").startswith(("measure_", "probe_", "mean_", "load_")) else "force"
    draw_lines(axes[0], data, over, strongest(data, forces, 8), "(a) " + what, what.split()[-1] + unit_of(units, forces))
    draw_lines(axes[1], data, over, strongest(data, energies, 12), "(b) energy", "energy" + unit_of(units, energies))
    if fields:
        draw_fields(axes[2], data, over, fields)
    axes[-1].set_xlabel(readable(over) + unit_of(units, [over]))
    axes[-1].set_xlim(data[over].min(), max(data[over].max(), np.nextafter(data[over].min(), np.inf)))
    for axis in axes:
        axis.grid(True, lw=0.4, color="0.88")
        axis.set_axisbelow(True)
    if options.title:
        figure.suptitle(options.title, fontsize=10.5, x=0.02, ha="left")
    figure.tight_layout()
    try:
        os.makedirs(os.path.dirname(options.figure) or ".", exist_ok=True)
        figure.savefig(options.figure, dpi=200)
    except (OSError, ValueError) as error:
        stop(f"cannot write {options.figure}: {error}")


def draw_fields(axis, data, over, fields):
    """Damage on the left scale, hardening on the right one."""
    axis.set_title("(c) largest damage and hardening", loc="left")
    handles = []
    if "phi_max" in fields:
        handles += axis.plot(data[over], data["phi_max"], lw=1.3, color=COLOURS[1], label=r"$\phi$ (left)")
        axis.set_ylim(0, 1.05)
        axis.set_ylabel(r"max $\phi$")
    if "alpha_max" in fields:
        right = axis.twinx() if "phi_max" in fields else axis
        handles += right.plot(data[over], data["alpha_max"], lw=1.3, color=COLOURS[0],
                              label=r"$\alpha$ (right)" if right is not axis else r"$\alpha$")
        right.set_ylabel(r"max $\alpha$")
        right.set_ylim(bottom=0)
        right.spines["right"].set_visible(right is not axis)
    axis.legend(handles=handles, frameon=False, loc="best")


if __name__ == "__main__":
    main()
