!> The version of the program.
module program_version
  implicit none
  private
  character(*), parameter, public :: VERSION = '0.2.0' !! as printed by --version
end module program_version
