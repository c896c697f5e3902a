!> Compares load numbers with the load tables, when the whole deck has been read.
module table_check
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use boundary, only: boundary_t, place_of_number
  use model, only: model_t
  implicit none
  private
  public :: check_tables, warn_sum

contains

  !> Check that every load number has a PROP. Number 0, the sum of all tables, needs no PROP; if
  !! there is no PROP at all, every factor is 1.
  subroutine check_tables(bc, defined, error)
    type(boundary_t), intent(in) :: bc
    integer, intent(in) :: defined(:)  !! numbers of the tables that PROPs define
    type(error_t), allocatable, intent(out) :: error
    type(place_t) :: place
    integer :: d, i

    if (size(defined) == 0) return
    do i = 1, size(bc%motion)
      call check(bc%motion(i)%table, bc%motion(i)%place)
    end do
    do i = 1, size(bc%pressure)
      call check(bc%pressure(i)%table, bc%pressure(i)%place)
    end do
    do i = 1, size(bc%dead)
      call check(bc%dead(i)%table, bc%dead(i)%place)
    end do
    do i = 1, size(bc%table, 2)
      do d = 1, 3
        if (bc%table(d, i) == 0 .or. any(defined == bc%table(d, i))) cycle
        call place_of_number(bc, bc%table(d, i), place)
        call check(bc%table(d, i), place)
        return
      end do
    end do
    if (.not. allocated(error)) call check_rivals(bc, defined, error)

  contains

    subroutine check(table, place)
      integer, intent(in) :: table
      type(place_t), intent(in) :: place

      if (allocated(error) .or. table == 0 .or. any(defined == table)) return
      call fail(error, DECK_ERROR, 'load table '//to_text(table)//' is not defined', place, &
                'add PROP,,'//to_text(table)//' to the commands and its data after END')
    end subroutine check

  end subroutine check_tables

  !> Check that the loads of nodes which TIE joins follow one load number. If there is only one
  !! table, load number 0 means this table.
  subroutine check_rivals(bc, defined, error)
    type(boundary_t), intent(in) :: bc
    integer, intent(in) :: defined(:)
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: HINT = 'give these nodes the same load number with FPROportional'
    character(:), allocatable :: text
    logical :: warned
    integer :: d, n

    if (.not. allocated(bc%rival)) return
    warned = .false.
    do n = 1, size(bc%rival, 2)
      do d = 1, 3
        associate (k => bc%table(d, n), rival => bc%rival(d, n))
          if (rival < 0 .or. (min(k, rival) == 0 .and. all(defined == max(k, rival)))) cycle
          if (.not. (abs(bc%force(d, n)) > 0.0_wp .or. &
                     (abs(bc%value(d, n)) > 0.0_wp .and. bc%fixed(d, n) /= 0))) cycle
          text = ' nodes that TIE joins at node '//to_text(n)//' follow '//named(k)//' and ' &
                 //named(rival)//' in direction '//to_text(d)
          if (bc%split(d, n)) then
            call fail(error, DECK_ERROR, 'the loads of'//text//', but the joined node can follow ' &
                      //'only one', bc%tied, HINT)
            return
          else if (.not. warned) then
            call warn('according to FPROportional,'//text//'; the joined node follows '//named(k), &
                      bc%tied, HINT)
          end if
          warned = .true.
        end associate
      end do
    end do

  contains

    function named(table)
      integer, intent(in) :: table
      character(:), allocatable :: named

      named = 'load table '//to_text(table)
      if (table == 0) named = 'the sum of all load tables'
    end function named

  end subroutine check_rivals

  !> Warn about loads of number 0, which follow the sum of several tables, if other loads have
  !! numbers of their own. If all loads follow the sum, as is usual in FEAP, the tables are meant to
  !! be added.
  subroutine warn_sum(model, ntable)
    type(model_t), intent(in) :: model
    integer, intent(in) :: ntable      !! number of tables that PROPs define
    character(*), parameter :: OWN = 'give it a load table of its own with '
    logical, allocatable :: sums(:, :) ! (3, nnode) no record gives the load number
    integer :: i

    associate (bc => model%bc)
      if (ntable < 2 .or. .not. has_numbers(bc)) return
      do i = 1, size(bc%motion)
        associate (m => bc%motion(i))
          if (m%table > 0 .or. .not. (any(abs(m%vector) > 0.0_wp) .or. m%rotates)) cycle
          call say('MOVE', m%place, OWN//'PROP k')
          exit
        end associate
      end do
      do i = 1, size(bc%pressure)
        if (bc%pressure(i)%table > 0) cycle
        call say('PRESsure', bc%pressure(i)%place, OWN//'PROP k')
        exit
      end do
      do i = 1, size(bc%dead)
        if (bc%dead(i)%table > 0) cycle
        if (any_body_force(model)) then
          call say('BODY FORCe', bc%dead(i)%place, 'BODY FORCe cannot have a load table of its ' &
                   //'own: give tables whose sum is its factor')
        else
          call say('PRESsure', bc%dead(i)%place, OWN//'PROP k')
        end if
      end do
      if (.not. allocated(bc%numbered)) return
      ! FPRO and EPRO may mean a 0, and the loads of tied nodes count at the node that they join
      sums = bc%table == 0 .and. .not. spread(bc%numbered, 1, 3) &
             .and. spread(model%mesh%used, 1, 3)
      if (any(abs(bc%force) > 0.0_wp .and. sums)) then
        call say('a nodal force (FORCe, EFORce, CFORce or CSURface)', &
                 hint=OWN//'FPROportional or EPROportional')
      end if
      if (any(abs(bc%value) > 0.0_wp .and. bc%fixed /= 0 .and. sums)) then
        call say('DISPlacement', hint=OWN//'FPROportional or EPROportional')
      end if
    end associate

  contains

    subroutine say(what, place, hint)
      character(*), intent(in) :: what
      type(place_t), intent(in), optional :: place
      character(*), intent(in) :: hint

      call warn(what//' follows the sum of '//to_text(ntable)//' load tables, while other loads ' &
                //'follow a single one', place, hint)
    end subroutine say

  end subroutine warn_sum

  !> Does any load or motion follow a table of its own?
  pure logical function has_numbers(bc)
    type(boundary_t), intent(in) :: bc

    has_numbers = any(bc%motion%table > 0) .or. any(bc%pressure%table > 0) .or. &
                  any(bc%dead%table > 0) .or. has_nodal_numbers(bc)
  end function has_numbers

  !> Does any nodal force or displacement follow a table of its own? Other load numbers of nodes
  !! have no effect.
  pure logical function has_nodal_numbers(bc)
    type(boundary_t), intent(in) :: bc

    has_nodal_numbers = any(bc%table > 0 .and. (abs(bc%force) > 0.0_wp .or. &
                                                (abs(bc%value) > 0.0_wp .and. bc%fixed /= 0)))
  end function has_nodal_numbers

  pure logical function any_body_force(model)
    type(model_t), intent(in) :: model
    integer :: i

    any_body_force = any([(any(abs(model%material(i)%body_force) > 0.0_wp), &
                           i=1, size(model%material))])
  end function any_body_force

end module table_check
