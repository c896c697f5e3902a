!> The log's account of a contact.
module listing_contact
  use base_kinds, only: wp
  use base_log, only: log_line
  use base_text, only: to_text
  use contact_pair, only: contact_t, surface_t
  implicit none
  private
  public :: list_contact, contact_size

contains

  !> Surfaces, points, laws with their numbers and sources.
  subroutine list_contact(contact)
    type(contact_t), intent(in) :: contact
    character(:), allocatable :: text
    integer :: i

    call log_line('contact   '//contact_size(contact))
    text = 'normal '//trim(contact%normal%name)//' '//to_text(contact%normal_prop(1))
    if (allocated(contact%auto)) text = text//' ('//contact%auto//')'
    if (contact%normal_prop(2) > 0.0_wp) text = text//', smooth to a penetration of ' &
                                                //to_text(contact%normal_prop(2))
    if (contact%on_pair) text = text//', bonded points against their partners'
    if (contact%border > 0.0_wp) text = text//', fading to the borders over ' &
                                        //to_text(contact%border)//' of an element'
    if (contact%balanced) text = text//', every point loads both surfaces'
    call log_line('          '//text)
    call log_line('          '//trim(contact%normal%source))
    if (contact%has_friction) then
      text = 'friction '//trim(contact%friction%name)//' '//to_text(contact%friction_prop(1)) &
             //', penalty '//to_text(contact%friction_prop(2))
      if (contact%has_after) text = text//', in steps that start at '//to_text(contact%after) &
                                    //' or later'
      call log_line('          '//text)
      call log_line('          '//trim(contact%friction%source))
    end if
    if (contact%has_cohesive) then
      text = 'cohesive '//trim(contact%cohesive%name)
      do i = 1, contact%cohesive%nprop
        text = text//' '//to_text(contact%cohesive_prop(i))
      end do
      if (contact%cohesive%option /= '') text = text//' '//trim(contact%cohesive%option)
      if (contact%tau > 0.0_wp) text = text//', viscous, time '//to_text(contact%tau)
      text = text//', released at '//to_text(contact%released)
      call log_line('          '//text)
      call log_line('          '//trim(contact%cohesive%source))
    end if
    text = 'depth '//to_text(contact%depth)
    if (contact%default_depth) text = text//' (half of the thinner body)'
    call log_line('          '//text)
  end subroutine list_contact

  !> 'sole': hemi 3- (9 elements, 225 points), block 3+ (4 elements, rigid).
  function contact_size(contact) result(text)
    type(contact_t), intent(in) :: contact
    character(:), allocatable :: text

    text = "'"//contact%name//"': "//side(contact%side(1))//', '//side(contact%side(2))

  contains

    function side(s) result(part)
      type(surface_t), intent(in) :: s
      character(:), allocatable :: part

      part = s%name//' ('//to_text(s%nelem)//' elements, '
      if (s%rigid) then
        part = part//'rigid)'
      else
        part = part//to_text(s%nelem*contact%nplain)//' points'
        if (contact%ncell > 1) part = part//', '//to_text(contact%nq - contact%nplain) &
                                      //' in an element that is cut'
        part = part//')'
      end if
    end function side
  end function contact_size

end module listing_contact
