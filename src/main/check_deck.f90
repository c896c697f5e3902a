!> --check: sizes, equations, memory; nothing is solved.
module check_deck
  use base_error, only: error_t
  use base_log, only: warning_count
  use base_text, only: to_text
  use base_system, only: available_memory_mb
  use command_type, only: run_t
  use contact_notes, only: warn_contacts
  use listing, only: warn_loose, warn_unread
  use listing_contact, only: contact_size
  use newton, only: prepare_newton
  implicit none
  private
  public :: print_check

contains

  subroutine print_check(job, error)
    type(run_t), intent(inout) :: job
    type(error_t), allocatable, intent(out) :: error
    integer :: b

    print '(a)', 'nodes      '//to_text(count(job%model%mesh%used))
    do b = 1, size(job%model%mesh%block)
      print '(a)', 'elements   '//to_text(job%model%mesh%block(b)%nelem)//' ' &
        //trim(job%model%mesh%block(b)%name)
    end do
    do b = 1, size(job%model%contact)
      print '(a)', 'contact    '//contact_size(job%model%contact(b))
    end do
    print '(a)', 'dofs       '//to_text(job%model%ndof)
    print '(a)', 'equations  '//to_text(job%model%neq)
    print '(a)', 'commands   '//to_text(size(job%command))
    call prepare_newton(job%newton, job%model, .true., error)
    if (allocated(error)) return
    print '(a)', 'memory     about '//to_text(job%newton%system%estimate_mb(), 3) &
      //' MB for a factorisation, '//to_text(available_memory_mb(), 3)//' MB available'
    call warn_contacts(job%model)
    call warn_loose(job%model)
    call warn_unread(job%model)
    if (warning_count() == 0) print '(a)', 'no problems found'
  end subroutine print_check

end module check_deck
