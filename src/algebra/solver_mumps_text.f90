!> What the error codes of MUMPS mean, in words.
module solver_mumps_text
  use base_error, only: error_t, fail, BUG, NO_SOLUTION, SYSTEM_ERROR
  implicit none
  private
  public :: describe_failure

contains

  !> Translate INFOG(1) and INFOG(2).
  subroutine describe_failure(code, detail, neq, error)
    integer, intent(in) :: code   !! INFOG(1) < 0
    integer, intent(in) :: detail !! INFOG(2)
    integer, intent(in) :: neq    !! equations
    type(error_t), allocatable, intent(out) :: error

    character(*), parameter :: MEMORY_HINT = &
      'use FACTor,SINGle (half the memory), a coarser mesh or a machine with more memory'

    select case (code)
    case (-6)
      call fail(error, NO_SOLUTION, 'the tangent is singular: its pattern has rank '//text(detail)//' of '//text(neq), &
        hint='look for nodes without stiffness or support')
    case (-10)
      call fail(error, NO_SOLUTION, 'the tangent is singular', hint='look for free bodies and missing supports')
    case (-7)
      call fail(error, SYSTEM_ERROR, 'no memory for the analysis of the equations ('//amount(detail)//' integers)', &
        hint=MEMORY_HINT)
    case (-13)
      call fail(error, SYSTEM_ERROR, 'no memory for the factorisation of '//text(neq)//' equations ('// &
        amount(detail)//' numbers could not be allocated)', hint=MEMORY_HINT)
    case (-5)
      call fail(error, SYSTEM_ERROR, 'no memory for the analysis of the equations ('//amount(detail)//' numbers)', &
        hint=MEMORY_HINT)
    case (-8, -14)
      call fail(error, SYSTEM_ERROR, 'the factorisation needs more integer work space than its largest margin allows')
    case (-9, -15, -11, -19)
      call fail(error, SYSTEM_ERROR, 'the factorisation needs more work space than its largest margin allows ('// &
        amount(detail)//' numbers short)', hint=MEMORY_HINT)
    case (-17, -20)
      call fail(error, SYSTEM_ERROR, 'a message buffer of MUMPS is too small')
    case (-51, -52)
      call fail(error, SYSTEM_ERROR, 'the equations are too many for the 32-bit integers of the ordering in MUMPS', &
        hint='use a coarser mesh')
    case (-90)
      call fail(error, SYSTEM_ERROR, 'MUMPS could not use its files on disk')
    case (-16)
      call fail(error, BUG, 'MUMPS got '//text(detail)//' equations')
    case (-4)
      call fail(error, BUG, 'MUMPS got an order of elimination that is no permutation, at equation '//text(detail))
    case (-2)
      call fail(error, BUG, 'MUMPS got '//amount(detail)//' entries, which is out of range')
    case (-3)
      call fail(error, BUG, 'MUMPS was called out of order (job '//text(detail)//')')
    case (-21)
      call fail(error, BUG, 'MUMPS was started in a mode that needs more processes')
    case (-22)
      call fail(error, BUG, 'MUMPS misses its array number '//text(detail))
    case (-23, -24, -25, -26, -27, -28, -29, -30, -31, -32, -33, -34, -35, -36, -37, -38, -39, -40)
      call fail(error, BUG, 'MUMPS got options that do not fit each other (code '//text(code)//', detail '//text(detail)//')')
    case (-800)
      call fail(error, BUG, 'MUMPS does not support this combination of options (detail '//text(detail)//')')
    case default
      call fail(error, SYSTEM_ERROR, 'MUMPS failed with code '//text(code)//', detail '//text(detail), &
        hint='see the description of INFOG(1) in the users'' guide of MUMPS')
    end select
  end subroutine describe_failure

  !> MUMPS gives large amounts as negative millions.
  pure function amount(n) result(t)
    integer, intent(in) :: n
    character(:), allocatable :: t

    if (n < 0) then
      t = text(-n)//' million'
    else
      t = text(n)
    end if
  end function amount

  pure function text(n) result(t)
    integer, intent(in) :: n
    character(:), allocatable :: t

    character(12) :: buffer

    write (buffer, '(i0)') n
    t = trim(buffer)
  end function text

end module solver_mumps_text
