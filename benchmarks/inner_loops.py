#!/usr/bin/env python3
"""inner_loops.py neon|avx2 OBJECT…: simulates the hottest loops of kernels on processors that are not at hand.

In the object files of the rooms nn and raster, as build/release and build/reach/arm have them, finds for each kernel the loop
that is densest in arithmetic, and prints how much of a processor's peak it reaches by llvm-mca-14, whose loads always
hit the cache: sums, products and fused ones a cycle, over the most fused ones a cycle.
"""
import re, subprocess, sys

KERNELS = {  # title: pattern of the mangled name behind the set's namespace
    "reduce_tile, float": r"11reduce_tileIfLi2ELiROWSE\w*12ValueProduct",
    "reduce_tile, bfloat16 in float": r"11reduce_tileIfLi2ELiROWSE\w*11PairProduct",
    "winograd_input, 4x4 of 3x3": r"14winograd_inputIfLNS\w*12WinogradFormE1ELb0E",
    "winograd_output, 4x4 of 3x3": r"15winograd_outputIfLNS\w*12WinogradFormE1E",
    "depthwise_row, 3 taps": r"(17depthwise_outputs|14depthwise_tile)IfLi3ELi1E",
    "barycentrics": r"(12barycentrics|5weigh|9weigh_run|11weigh_mixed)[EIR]",
    "draw_triangles": r"(14draw_triangles|9draw_rows)",
    "texture lookups": r"7look_up",
}
SETS = {  # objdump, namespaces, rows of a tile, arch and processors of llvm-mca, arithmetic, a fused operation
    "neon": ("aarch64-linux-gnu-objdump", "(2nn4neon|6raster8portable)", "10", "aarch64", ["neoverse-n1", "apple-m1"],
             r"^f(n?mla|n?mls|n?mul|add|sub|div|n?madd|n?msub)\b", "fmla v{0}.4s, v30.4s, v31.4s"),
    "avx2": ("objdump", "4avx2", "6", "x86-64", ["skylake", "znver3"],
             r"^v(fn?m(add|sub)\d*|add|sub|mul|div)[ps][sd]\b", "vfmadd231ps %ymm14, %ymm15, %ymm{0}"),
}
objdump, space, rows, arch, cpus, arithmetic, fused = SETS[sys.argv[1]]


def cycles(cpu, lines):
    out = subprocess.run(["llvm-mca-14", "-march=" + arch, "-mcpu=" + cpu, "-iterations=200"], capture_output=True,
                         text=True, input="\n".join(lines) + "\n", check=True).stdout
    return int(re.search(r"Total Cycles:\s+(\d+)", out)[1]) / 200


def loops_of(function):
    """Instructions of each loop, up to its branch."""
    code = re.findall(r"^\s*([0-9a-f]+):\t(.*)$", function, re.M)
    places = {address: i for i, (address, _) in enumerate(code)}
    for i, (_, text) in enumerate(code):
        branch = re.match(r"(?:j\w+|b\.\w+|b|cbn?z|tbn?z)\s.*?\b([0-9a-f]+) <", text)
        if branch and places.get(branch[1], i) < i:
            yield [re.sub(r"\s*(#|//|<).*", "", line) for _, line in code[places[branch[1]]:i]]


functions = []
for path in sys.argv[2:]:
    dump = subprocess.run([objdump, "-d", "--no-show-raw-insn", path], capture_output=True, text=True, check=True).stdout
    functions += re.findall(r"^[0-9a-f]+ <(\S+)>:\n(.*?)\n\n", dump + "\n\n", re.M | re.S)
independent = 30 if arch == "aarch64" else 14
peaks = [independent / cycles(cpu, [fused.format(i) for i in range(independent)]) for cpu in cpus]
for title, pattern in KERNELS.items():
    name = re.compile(space + r"\w*?" + pattern.replace("ROWS", rows))
    loops = [loop for symbol, body in functions if name.search(symbol) for loop in loops_of(body)]
    counts = [sum(bool(re.match(arithmetic, line)) for line in loop) for loop in loops]
    enough = [pair for pair in zip(counts, loops) if pair[0] >= min(9, max(counts))]
    count, loop = max(enough, key=lambda pair: pair[0] / len(pair[1]), default=(0, []))
    shares = [f"{cpu} {count / cycles(cpu, loop) / peak:.2f}" for cpu, peak in zip(cpus, peaks) if count]
    print(f"{title}: {count} of {len(loop)} instructions are arithmetic; {', '.join(shares) or 'no loop found'}")
