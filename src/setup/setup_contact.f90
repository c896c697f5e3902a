!> CONTact: reserved; this version solves without contact.
module setup_contact
  use base_error, only: error_t, fail, DECK_ERROR
  use deck_record, only: record_t
  use deck_stream, only: deck_t
  use setup_build, only: build_t
  implicit none
  private
  public :: read_contact

contains

  !> CONTact,name.
  subroutine read_contact(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error

    associate (unused => build%in_set, none => deck%consumed); end associate
    call fail(error, DECK_ERROR, 'contact is not available yet', record%place(1), &
      'this version solves decks without CONTact')
  end subroutine read_contact

end module setup_contact
