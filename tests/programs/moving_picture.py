"""Reads PNG files, moving ones too (APNG), by the specification alone, and checks what `render` says of them.

moving_picture.py frames FILE COUNT MILLISECONDS STILL...   frames from the first on are the stills
moving_picture.py opacity FILE COVERAGE                     opacity is the grey of another picture
moving_picture.py over FILE R G B OPAQUE [encoded]          laid over a colour in linear light it is the opaque picture
moving_picture.py shadow FILE OPAQUE                        laid over white without this, so are its black pixels
"""
import struct
import sys
import zlib


def chunks(path):
    """(name, content) of each chunk, whose checksums must be right."""
    data = open(path, "rb").read()
    assert data[:8] == b"\x89PNG\r\n\x1a\n", path
    at, found = 8, []
    while at < len(data):
        (size,) = struct.unpack(">I", data[at:at + 4])
        name, content = data[at + 4:at + 8], data[at + 8:at + 8 + size]
        assert zlib.crc32(name + content) == struct.unpack(">I", data[at + 8 + size:at + 12 + size])[0], (path, name)
        found.append((name, content))
        at += 12 + size
    assert found[-1] == (b"IEND", b"") and at == len(data), path
    return found


def pixels(packed, width, height, channels):
    """Rows of bytes, unfiltered."""
    raw, stride = zlib.decompress(packed), width * channels
    assert len(raw) == height * (stride + 1), "the picture data have another extent"
    rows, above = [], bytes(stride)
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for x in range(stride):
            left = row[x - channels] if x >= channels else 0
            corner = above[x - channels] if x >= channels else 0
            near = min((left, above[x], corner), key=lambda v: abs(left + above[x] - corner - v))  # Paeth
            row[x] = (row[x] + (0, left, above[x], (left + above[x]) // 2, near)[kind]) & 255
        rows.append(bytes(row))
        above = row
    return rows


def read(path):
    """Frames as lists of rows of RGBA, and the milliseconds that each shows; a still is one frame of 0."""
    parts = chunks(path)
    width, height, bits, colour, _, _, interlaced = struct.unpack(">IIBBBBB", parts[0][1])
    assert parts[0][0] == b"IHDR" and bits == 8 and colour in (2, 6) and interlaced == 0, path
    channels = 3 if colour == 2 else 4
    controls, data, expected, declared = [], [], 0, None
    for name, content in parts[1:-1]:
        if name == b"acTL":
            declared, plays = struct.unpack(">II", content)
            assert plays == 0 and not data
        elif name == b"fcTL":
            controls.append(struct.unpack(">IIIIIHHBB", content))
            assert controls[-1][0] == expected
            expected, data = expected + 1, data + [b""]
        elif name == b"IDAT":
            assert len(data) <= 1, "IDAT belongs to the first frame"
            data = [data[0] + content] if data else [content]
        elif name == b"fdAT":
            assert struct.unpack(">I", content[:4])[0] == expected and len(data) > 1
            expected += 1
            data[-1] += content[4:]
    if declared is None:
        controls = [(0, width, height, 0, 0, 0, 1000, 0, 0)]
    assert len(controls) == len(data) and declared in (None, len(data)), path
    assert controls[0][1:5] == (width, height, 0, 0), "the first frame is the whole picture"
    canvas, frames, times = [bytearray(4 * width) for _ in range(height)], [], []
    for (_, w, h, left, top, number, of, dispose, blend), packed in zip(controls, data):
        assert left + w <= width and top + h <= height and dispose == 0
        for y, row in enumerate(pixels(packed, w, h, channels)):
            for x in range(w):
                pixel = row[channels * x:channels * (x + 1)] + (b"\xff" if channels == 3 else b"")
                assert blend == 0 or pixel[3] in (0, 255), "half opaque pixels are laid over others"
                if blend == 0 or pixel[3]:
                    canvas[top + y][4 * (left + x):4 * (left + x + 1)] = pixel
        frames.append([bytes(row) for row in canvas])
        times.append(1000 * number // of)
    compare_with_pillow(path, frames)
    return frames, times


def compare_with_pillow(path, frames):
    try:
        from PIL import Image, ImageSequence
    except ImportError:
        return
    picture = Image.open(path)
    assert getattr(picture, "n_frames", 1) == len(frames), path
    for ours, theirs in zip(frames, ImageSequence.Iterator(picture)):
        assert theirs.convert("RGBA").tobytes() == b"".join(ours), path + ": Pillow reads other pixels"


def still(path):
    return b"".join(read(path)[0][0])


def light(level):
    share = level / 255
    return share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4


def level(amount):
    return 255 * (12.92 * amount if amount <= 0.0031308 else 1.055 * amount ** (1 / 2.4) - 0.055)


def main(job, path, *words):
    if job == "frames":
        frames, times = read(path)
        assert len(frames) == int(words[0]), len(frames)
        assert set(times) == {int(words[1])}, times
        for index, name in enumerate(words[2:]):
            assert b"".join(frames[index]) == still(name), "frame %d is not %s" % (index, name)
    elif job == "opacity":
        own, coverage = still(path), still(words[0])
        assert own[3::4] == coverage[0::4] and 0 in own[3::4] and 255 in own[3::4]
        assert any(0 < opacity < 255 for opacity in own[3::4]), "no pixel is half covered"
    elif job == "over":
        own, opaque = still(path), still(words[3])
        behind = [255 * float(word) for word in words[:3]]
        forth, back = (float, float) if words[4:] == ("encoded",) else (light, level)
        worst = 0
        for at in range(0, len(own), 4):
            share = own[at + 3] / 255
            for c in range(3):
                mixed = back(share * forth(own[at + c]) + (1 - share) * forth(behind[c]))
                worst = max(worst, abs(mixed - opaque[at + c]))
        # Half a level of the colour and of the opacity, and as much of the opaque picture, where the curve is
        # steepest: near black it is 12.92 times as steep as at the white that opacity scales.
        assert worst <= 3, worst
    elif job == "shadow":
        own, opaque = still(path), still(words[0])
        black = [at for at in range(0, len(own), 4) if own[at:at + 3] == bytes(3) and own[at + 3] > 20]
        assert len(black) > 20, len(black)
        assert all(abs(255 - own[at + 3] - opaque[at]) <= 1 for at in black)
    else:
        raise SystemExit(__doc__)


main(*sys.argv[1:])
