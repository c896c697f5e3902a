"""Write pairs.inp, with one pair of blocks for each pair of surface types.

python -m verification.benchmark.contact_patch.pairs
"""

import pathlib

TYPES = {
    "q1e9": ["TYPE Q1E9"],
    "q2": ["TYPE Q2"],
    "iga2": ["TYPE IGA 2"],
    "iga3": ["TYPE IGA 3"],
    "q1n2": ["TYPE Q1", "ENRIch {face} 2"],
    "q1n3": ["TYPE Q1", "ENRIch {face} 3"],
    "q1n21": ["TYPE Q1", "ENRIch {face} 2 RAISe 1"],
    "q1e9n2": ["TYPE Q1E9", "ENRIch {face} 2 EAS"],
    "q2n2": ["TYPE Q2", "ENRIch {face} 2"],
}
HEAD = """FEAP ** Patch test of contact: two blocks with meshes that do not match, all pairs of surface types
  ndm = 3
! Written by pairs.py.
! Problem: pairs of unit blocks, one on the other, guided at their sides and pressed together; all pairs
!          occupy the same place but do not interact with each other.
! Units:   any consistent ones (length 1, modulus 1).
! Answer:  uniaxial strain and a uniform stress; each block shortens by (0.2 - p/eps)/2, p: pressure.

PARAmeters
  q = 3                            ! integration points of a surface element per direction
  eps = 10

MATErial 1
  SOLId
    ELAStic NEOHook 1.0 0.3
    FINIte VOLUme 3

"""
GUIDES = """EBOUndary
  1 0.0  1 0 0
  1 1.0  1 0 0
  2 0.0  0 1 0
  2 1.0  0 1 0

"""
TAIL = """END

BATCh
  PROP,,1
  DT,,0.5
  LOOP,time,2
    TIME
    LOOP,newton,25
      UTAN,,1
    NEXT,newton
  NEXT,time
  PLOT
END
                                   ! a blank record: the factor is the time

STOP
"""


def block(name, z, knots, lines, face):
    """A unit block whose knots differ from those of the block in contact with it."""
    rows = [
        f"PATCh,{name}",
        f"  BOX 0 0 {z}  1 1 1",
        f"  KNOTs,1 {knots[0]}",
        f"  KNOTs,2 {knots[1]}",
        "  KNOTs,3 0.5",
    ]
    rows += ["  " + line.format(face=face) for line in lines]
    return "\n".join([*rows, "  MATErial 1", "", ""])


def pair(low, high, curves):
    """A lower block of one type, an upper block of another type, and the contact between them."""
    name = f"{low}-{high}"
    a, b = f"{name}-a", f"{name}-b"
    curves += [f"  CONTact {name} {side} FORCe 3" for side in (1, 2)]
    curves += [f"  FORCe {a} 3- 3", f"  FORCe {b} 3+ 3"]
    return (
        block(a, -1, ("0.4", "0.3 0.7"), TYPES[low], "3+")
        + block(b, 0, ("0.3 0.5", "0.55"), TYPES[high], "3-")
        + f"FIX,{a},3-  0 0 1\nMOVE,{b},3+  TRANslate * * -0.2  PROP 1\n\n"
        + f"CONTact,{name}\n  SURFaces {b} 3-  {a} 3+\n  SCHEme HALFpass\n"
        + "  NORMal PENAlty eps\n  QUADrature q q\n\n"
    )


def main():
    curves, names = [], list(TYPES)
    text = HEAD + "".join(
        pair(names[i], names[j], curves) for i in range(len(names)) for j in range(i, len(names))
    )
    text += GUIDES + "\n".join(["CURVe,force", *curves, "", ""]) + TAIL
    (pathlib.Path(__file__).parent / "pairs.inp").write_text(text, encoding="utf-8")


main()
