!> --check: prints sizes, equations, memory and problems of a deck; nothing is solved.
module check_deck
  use base_error, only: error_t
  use base_kinds, only: wp
  use base_log, only: warning_count, print_lines
  use base_system, only: available_memory_mb
  use base_text, only: to_text
  use command_type, only: run_t
  use contact_start, only: warn_contacts
  use command_program, only: has_command
  use listing, only: list_free_bodies, warn_loose, warn_unread
  use listing_contact, only: contact_size
  use newton, only: prepare_newton
  implicit none
  private
  public :: print_check

  !> The ways to store factors are listed if a factorisation needs more memory than this [MB].
  real(wp), parameter :: WORTH_A_CHOICE = 100.0_wp

contains

  subroutine print_check(job, error)
    type(run_t), intent(inout) :: job
    type(error_t), allocatable, intent(out) :: error
    character(64), allocatable :: way(:)
    real(wp), allocatable :: mb(:)
    logical :: symmetric
    integer :: i

    associate (model => job%model, newton => job%step%newton)
      print '(a)', 'nodes      '//to_text(count(model%mesh%used))
      do i = 1, size(model%mesh%block)
        print '(a)', 'elements   '//to_text(model%mesh%block(i)%nelem)//' ' &
          //trim(model%mesh%block(i)%name)
      end do
      do i = 1, size(model%contact)
        print '(a)', 'contact    '//contact_size(model%contact(i))
      end do
      print '(a)', 'dofs       '//to_text(model%ndof)
      print '(a)', 'equations  '//to_text(model%neq)
      print '(a)', 'commands   '//to_text(size(job%program%command))
      symmetric = .not. has_command(job, 'utan')
      call prepare_newton(newton, model, 0, symmetric, error)
      if (allocated(error)) return
      print '(a)', 'memory     about '//to_text(newton%system%estimate_mb(), 3) &
        //' MB needed for a factorisation, '//to_text(available_memory_mb(), 3)//' MB available'
      allocate (mb(0))
      if (newton%system%estimate_mb() > WORTH_A_CHOICE) then
        call newton%system%list_memory(newton%asm%k, way, mb, error)
        if (allocated(error)) return
      end if
      do i = 1, size(mb)
        print '(a)', '           about '//to_text(mb(i), 3)//' MB '//trim(way(i))
      end do
      call print_lines()
      call list_free_bodies(model, warns=.not. has_command(job, 'tran'))
      call warn_contacts(model)
      call warn_loose(model)
      call warn_unread(model)
    end associate
    if (warning_count() == 0) print '(a)', 'no problems found'
  end subroutine print_check

end module check_deck
