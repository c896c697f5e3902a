!> What MUMPS has to say, in words.
module solver_mumps_text
  use base_kinds, only: wp, i8
  use base_error, only: error_t, fail, BUG, NO_SOLUTION, SYSTEM_ERROR
  use base_text, only: to_text
  implicit none
  private
  public :: check_memory, describe_failure

  character(*), parameter :: COARSER = 'use a coarser mesh or a machine with more memory'
  character(*), parameter :: HALF = 'FACTor,SINGle needs about half; else '//COARSER

contains

  !> Refuse before the machine starts to swap.
  subroutine check_memory(need_mb, available_mb, neq, single, error)
    real(wp), intent(in) :: need_mb, available_mb
    integer, intent(in) :: neq
    logical, intent(in) :: single !! factors in single precision
    type(error_t), allocatable, intent(out) :: error

    if (need_mb <= available_mb) return
    call fail(error, SYSTEM_ERROR, 'the factorisation of '//to_text(neq) &
              //' equations needs about ' &
              //to_text(nint(need_mb, i8))//' MB of memory, '//to_text(nint(available_mb, i8)) &
              //' MB are available')
    error%hint = HALF
    if (single) error%hint = COARSER
  end subroutine check_memory

  !> Translate INFOG(1) and INFOG(2).
  subroutine describe_failure(code, detail, neq, error)
    integer, intent(in) :: code   !! INFOG(1) < 0
    integer, intent(in) :: detail !! INFOG(2)
    integer, intent(in) :: neq    !! equations
    type(error_t), allocatable, intent(out) :: error

    select case (code)
    case (-6)
      call fail(error, NO_SOLUTION, 'the tangent is singular: its pattern has rank ' &
                //to_text(detail)//' of '//to_text(neq), &
                hint='look for nodes without stiffness or support')
    case (-10)
      call fail(error, NO_SOLUTION, 'the tangent is singular', &
                hint='look for free bodies and missing supports')
    case (-5, -7)
      call fail(error, SYSTEM_ERROR, 'no memory for the analysis of '//to_text(neq) &
                //' equations ('//amount(detail)//' numbers could not be allocated)', hint=COARSER)
    case (-13)
      call fail(error, SYSTEM_ERROR, 'no memory for the factorisation of '//to_text(neq) &
                //' equations ('//amount(detail)//' numbers could not be allocated)', hint=HALF)
    case (-8, -9, -11, -14, -15, -19)
      call fail(error, SYSTEM_ERROR, 'pivoting needs far more work space than foreseen (' &
                //amount(detail)//' numbers short)', &
                hint='the tangent may be close to singular; '//HALF)
    case (-17, -20)
      call fail(error, SYSTEM_ERROR, 'a message buffer of MUMPS is too small')
    case (-51, -52)
      call fail(error, SYSTEM_ERROR, to_text(neq) &
                //' equations are too many for the 32-bit integers of MUMPS', &
                hint='use a coarser mesh')
    case (-90)
      call fail(error, SYSTEM_ERROR, 'MUMPS could not use its files on disk')
    case (-2, -3, -4, -16, -40:-21, -800)
      call fail(error, BUG, 'MUMPS was called in a wrong way (code '//to_text(code)//', detail ' &
                //to_text(detail)//')')
    case default
      call fail(error, SYSTEM_ERROR, 'MUMPS failed with code '//to_text(code)//', detail ' &
                //to_text(detail), &
                hint='see INFOG(1) in the users'' guide of MUMPS')
    end select
  end subroutine describe_failure

  !> MUMPS gives large amounts as negative millions.
  pure function amount(n) result(text)
    integer, intent(in) :: n
    character(:), allocatable :: text

    text = to_text(abs(n))
    if (n < 0) text = text//' million'
  end function amount

end module solver_mumps_text
