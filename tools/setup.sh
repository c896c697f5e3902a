#!/bin/sh
# Install what `make check` and `make demo` need; quick and silent if nothing is missing.
# usage: tools/setup.sh            compiler, libraries, Python packages of `post` in .venv
#        tools/setup.sh dev        also the tools of `make lint`, `make coverage` and `make doc`
#        tools/setup.sh bench      also FElupe and CalculiX, with which `make bench` compares
#        tools/setup.sh mesh       also Gmsh and TetGen, which `python -m post mesh` starts
#        MPI=1 tools/setup.sh      MUMPS and compiler for several ranks, instead of the serial ones
#        tools/setup.sh libraries  install nothing, only report what is missing
# Missing packages are installed if there is apt and the permission to use it (root or sudo); otherwise
# one sentence names them, and the exit code is 1.
set -eu
cd "$(dirname "$0")/.."
unset MAKEFLAGS MFLAGS MAKELEVEL 2>/dev/null || true
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

compiler=gfortran mumps=mumps mumps_apt=libmumps-seq-dev
[ "${MPI:-}" != 1 ] || compiler=mpifort mumps=mumps_mpi mumps_apt='libmumps-dev libopenmpi-dev openmpi-bin'
APT="gfortran make pkg-config $mumps_apt libmetis-dev libhdf5-dev libopenblas-dev
     python3 python3-venv libgl1 libegl1 libosmesa6 libxrender1"

# --- What is missing ---------------------------------------------------------------------------

has() { command -v "$1" >/dev/null 2>&1; }

# Whether a program that contains $2 can be linked with $1 and the folders that the Makefile found.
links() {
  printf '%s\nend\n' "$2" > "$work/try.f90"
  # shellcheck disable=SC2086
  $FC $INCLUDE "$work/try.f90" $folders $1 -J"$work" -o "$work/try" >/dev/null 2>&1
}

# Whether library $1 seems to be installed; used without a compiler, when linking cannot be tried.
installed() {
  for folder in $(printf '%s\n' $folders | sed 's/^-L//') /usr/lib /usr/lib64 /usr/lib/* \
      /usr/lib/*/hdf5/serial /usr/local/lib /usr/local/lib64; do
    for file in "$folder/lib$1".so "$folder/lib$1".a "$folder/lib$1".dylib; do
      [ ! -e "$file" ] || return 0
    done
  done
  return 1
}

missing_libraries() {
  LIBS='' INCLUDE='' MUMPS_LIBS=${MUMPS_LIBS:-}
  ! has make || eval "$(make -s settings)"
  folders=$(printf '%s\n' $LIBS | grep '^-L' || true)
  if ! has "$FC"; then
    name=$(printf '%s\n' $MUMPS_LIBS | sed -n 's/^-l//p' | head -n 1)
    installed "${name:-dmumps_seq}" || echo $mumps
    for name in metis hdf5_fortran openblas; do installed $name || echo ${name%_fortran}; done
    return
  fi
  links "$LIBS" "use hdf5
include 'dmumps_struc.h'
include 'smumps_struc.h'" && return
  links '' "include 'dmumps_struc.h'" && links "$MUMPS_LIBS -lopenblas" '' || echo $mumps
  links -lmetis '' || echo metis
  links '-lhdf5_fortran -lhdf5' 'use hdf5' || echo hdf5
  links -lopenblas '' || echo openblas
}

# Find a Python that can make a virtual environment; on Debian venv is a separate package.
find_python() {
  for name in python3 python3.14 python3.13 python3.12 python3.11 /usr/bin/python3; do
    if has "$name" && "$name" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
      echo "$name"
      return
    fi
  done
}

missing_program() {
  FC=${FC:-$compiler}
  has make || echo make
  has "$FC" || echo $compiler
  missing_libraries
}

missing_python() {
  [ -x .venv/bin/python ] && .venv/bin/python -c '' 2>/dev/null || [ -n "$(find_python)" ] || echo python
  if has ldconfig || [ -x /sbin/ldconfig ]; then
    PATH=$PATH:/sbin ldconfig -p > "$work/libraries"
    for name in libGL.so.1 libEGL.so.1 libOSMesa.so libXrender.so.1; do
      grep -q "$name" "$work/libraries" || { echo pictures; return; }
    done
  fi
}

# What item $1 is, and its package names for apt, dnf, conda and Spack.
names() {
  case $1 in
    make)     echo 'make|make|make|make|make' ;;
    gfortran) echo 'the Fortran compiler|gfortran|gcc-gfortran|gfortran|gcc languages=fortran' ;;
    mumps)    echo 'MUMPS without MPI|libmumps-seq-dev|MUMPS-devel|mumps-seq|mumps~mpi' ;;
    mpifort)  echo 'MPI with its compiler|libopenmpi-dev openmpi-bin|openmpi-devel|openmpi|openmpi' ;;
    mumps_mpi) echo 'MUMPS with MPI|libmumps-dev|MUMPS-openmpi-devel|mumps-mpi|mumps+mpi' ;;
    metis)    echo 'METIS|libmetis-dev|metis-devel|metis|metis' ;;
    hdf5)     echo 'HDF5 with Fortran|libhdf5-dev|hdf5-devel|hdf5|hdf5+fortran~mpi' ;;
    openblas) echo 'OpenBLAS|libopenblas-dev|openblas-devel|openblas|openblas' ;;
    python)   echo 'Python 3.11 with venv|python3-venv|python3|python|python' ;;
    pictures) echo 'OpenGL for pictures|libgl1 libegl1 libosmesa6 libxrender1|mesa-libGL mesa-libEGL mesa-libOSMesa libXrender|mesalib|mesa' ;;
  esac
}

report_missing() {
  what='' apt='' dnf='' conda='' spack=''
  for item; do
    row=$(names "$item")
    what="$what${what:+, }$(echo "$row" | cut -d'|' -f1)"
    apt="$apt $(echo "$row" | cut -d'|' -f2)"; dnf="$dnf $(echo "$row" | cut -d'|' -f3)"
    conda="$conda $(echo "$row" | cut -d'|' -f4)"; spack="$spack $(echo "$row" | cut -d'|' -f5)"
  done
  cat >&2 <<TEXT
missing: $what; install it with one of
  apt install$apt
  dnf install$dnf
  conda install -c conda-forge$conda
  spack install$spack
or load modules of your cluster. MUMPS_DIR= METIS_DIR= HDF5_DIR= set folders, MUMPS_LIBS= library names; see make help.
TEXT
  exit 1
}

# --- Installation --------------------------------------------------------------------------------

apt_install() {
  has apt-get || return 0
  sudo=
  if [ "$(id -u)" != 0 ]; then
    if has sudo && { sudo -n true 2>/dev/null || [ -t 0 ]; }; then sudo=sudo; else return 0; fi
  fi
  echo "installing packages with apt (only once)"
  # shellcheck disable=SC2086
  { $sudo env DEBIAN_FRONTEND=noninteractive apt-get -q update &&
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get -q install -y --no-install-recommends $APT; } \
    > "$work/apt.log" 2>&1 < /dev/null || { tail -n 5 "$work/apt.log" >&2; echo 'apt could not install them' >&2; }
}

# Install the packages listed in $1 into .venv; a copy of the list there marks them as installed.
pip_install() {
  copy=.venv/$(basename "$1")
  cmp -s "$1" "$copy" && return
  echo "installing Python packages of $1 into .venv (only once)"
  if ! .venv/bin/python -m pip install --quiet --disable-pip-version-check --requirement "$1" \
    --constraint post/requirements.txt < /dev/null; then
    echo "missing: the Python packages of $1; pip could not install them into .venv; check the network" >&2
    return 1
  fi
  cp "$1" "$copy"
}

case ${1:-} in
  libraries)
    lack=$(missing_program)
    # shellcheck disable=SC2086
    [ -z "$lack" ] || report_missing $lack ;;
  '' | dev | bench | mesh)
    lack=$(missing_program; missing_python)
    if [ -n "$lack" ]; then
      apt_install
      lack=$(missing_program; missing_python)
    fi
    # shellcheck disable=SC2086
    [ -z "$lack" ] || report_missing $lack
    if ! .venv/bin/python -c '' 2>/dev/null; then
      rm -rf .venv
      "$(find_python)" -m venv .venv
    fi
    pip_install post/requirements.txt
    case ${1:-} in
      dev) pip_install tools/requirements-dev.txt ;;
      mesh) # the wheel of Gmsh needs desktop libraries
        if ! .venv/bin/python .venv/bin/gmsh -version >/dev/null 2>&1; then
          pip_install tools/requirements-mesh.txt
          .venv/bin/python .venv/bin/gmsh -version >/dev/null 2>&1 ||
            { APT='libglu1-mesa libxcursor1 libxft2 libxinerama1 libxext6'; apt_install; }
        fi ;;
      bench) # programs that cannot be installed are left out of the comparison
        has ccx || { APT=calculix-ccx; apt_install; }
        pip_install tools/requirements-bench.txt || true ;;
    esac ;;
  *)
    sed -n '2,/^set/s/^# //p' "$0"
    exit 1 ;;
esac
