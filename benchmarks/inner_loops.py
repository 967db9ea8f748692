#!/usr/bin/env python3
"""inner_loops.py: simulates the hottest loops of the kernels on processors that are not at hand.

Compiles the rooms nn and raster to assembler for aarch64 and x86, finds in each kernel the innermost loop with the most
arithmetic, and prints how much of a processor's peak llvm-mca-14 says it reaches: vector sums, products and fused ones a
cycle, over the most fused ones a cycle. Run it in the repository's root; needs g++-aarch64-linux-gnu and llvm-14.
"""
import pathlib, re, subprocess, sys

KERNELS = {  # title: room, and a pattern of the mangled name
    "reduce_tile, float": ("nn", r"11reduce_tileIfLi2ELi(ROWS)E\w*12ValueProduct"),
    "reduce_tile, bfloat16 in float": ("nn", r"11reduce_tileIfLi2ELi(ROWS)E\w*11PairProduct"),
    "winograd_input, 4x4 of 3x3": ("nn", r"14winograd_inputIfLNS\w*12WinogradFormE1ELb0E"),
    "winograd_output, 4x4 of 3x3": ("nn", r"15winograd_outputIfLNS\w*12WinogradFormE1E"),
    "depthwise_row, 3x3": ("nn", r"17depthwise_outputsIfLi3ELi1E"),
    "barycentrics": ("raster", r"12barycentrics"),
    "draw_triangles": ("raster", r"14draw_triangles"),
    "texture lookups": ("raster", r"7look_up"),
}
FLAGS = "-std=c++20 -O2 -S -o - -Iinclude -isystem /usr/include/eigen3 -ffp-contract=off".split()
SIDES = {  # compiler, namespaces of nn and raster, rows of a tile, processors, arithmetic, a fused one
    "neon": ("aarch64-linux-gnu-g++", {"nn": "4neon", "raster": "8portable"}, 12, ["neoverse-n1", "apple-m1"],
             r"\tf(mla|mls|mul|add|sub|div|madd|msub|nmadd|nmsub)\t", "fmla v{0}.4s, v30.4s, v31.4s"),
    "avx2": ("g++", {"nn": "4avx2", "raster": "4avx2"}, 6, ["skylake", "znver3"],
             r"\tv(f?n?m?(add|sub)|mul|div)\w*[ps][sd]\t", "vfmadd231ps %ymm14, %ymm15, %ymm{0}"),
}


def simulate(cpu, side, lines):
    arch = "aarch64" if side == "neon" else "x86-64"
    text = "\n".join(lines) + "\n"
    out = subprocess.run(["llvm-mca-14", f"-march={arch}", f"-mcpu={cpu}", "-iterations=200"], input=text,
                         capture_output=True, text=True)
    if out.returncode:
        sys.exit(out.stderr)
    return int(re.search(r"Total Cycles:\s+(\d+)", out.stdout)[1]) / 200


def loops(body):
    """Innermost loops: from a label to a branch back to it, with no such loop inside."""
    places = {line[:-1]: i for i, line in enumerate(body) if re.match(r"\.L\w+:$", line)}
    found = []
    for i, line in enumerate(body):
        branch = re.match(r"\t(b\.?\w*|cbn?z|tbn?z|j\w+)\t.*?(\.L\w+)$", line)
        if branch and places.get(branch[2], i) < i:
            found.append((places[branch[2]], i))
    return [(a, b) for a, b in found if not any(a <= c and d <= b and (a, b) != (c, d) for c, d in found)]


for side, (compiler, spaces, rows, cpus, arithmetic, fused) in SIDES.items():
    rooms = {room: subprocess.run([compiler, *FLAGS, f"cmake/compiled/{room}.cpp"], capture_output=True, text=True,
                                  check=True).stdout for room in spaces}
    peaks = [12 / simulate(cpu, side, [fused.format(i) for i in range(12)]) for cpu in cpus]
    for title, (room, pattern) in KERNELS.items():
        name = spaces[room] + r"\w*" + pattern.replace("ROWS", str(rows))
        best, most = None, 0
        for function in re.finditer(rf"^(\w*{name}\w*):\n(.*?)\n\t\.size", rooms[room], re.M | re.S):
            body = function[2].split("\n")
            for a, b in loops(body):
                count = sum(bool(re.search(arithmetic, line)) for line in body[a:b])
                if count > most:
                    best, most = body[a + 1:b], count
        if best is None:
            print(f"| {title} | {side} | no loop |")
            continue
        best = [line for line in best if line.startswith("\t") and not line.startswith("\t.")]
        for cpu, peak in zip(cpus, peaks):
            cycles = simulate(cpu, side, best)
            print(f"| {title} | {side} | {cpu} | {most} | {len(best)} | {cycles:.1f} | {most / cycles / peak:.2f} |")
