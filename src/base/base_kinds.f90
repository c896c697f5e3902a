!> The kinds of numbers that the program uses.
module base_kinds
  use, intrinsic :: iso_fortran_env, only: int64, real64
  implicit none
  private
  integer, parameter, public :: wp = real64 !! every real number
  integer, parameter, public :: i8 = int64  !! numbers of nonzeros and file offsets
end module base_kinds
