"""Recipe for Spack. UNTESTED: nobody has built it yet.

Copy it to packages/bezel/ of a Spack repository, and set `url` or `git` to where the sources are.
"""

from spack.package import MakefilePackage, depends_on, license, version


class Bezel(MakefilePackage):
    """Finite elements for contact, friction and debonding of solids."""

    license("BSD-3-Clause")
    version("0.2.0")

    depends_on("fortran", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("mumps~mpi+metis")
    depends_on("metis")
    depends_on("hdf5+fortran~mpi")
    depends_on("openblas")
    depends_on("python@3.11:", type="run")
    depends_on("py-numpy", type="run")
    depends_on("py-h5py", type="run")
    depends_on("py-matplotlib", type="run")

    @property
    def build_targets(self):
        names = {"mumps": "MUMPS_DIR", "metis": "METIS_DIR", "hdf5": "HDF5_DIR"}
        return [f"{name}={self.spec[package].prefix}" for package, name in names.items()]

    @property
    def install_targets(self):
        return ["install", f"PREFIX={self.prefix}", *self.build_targets]
