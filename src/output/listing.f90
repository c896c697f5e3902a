!> The log's account of what was read and which formulations run.
module listing
  use base_log, only: log_line, warn
  use base_text, only: to_text
  use contact_report, only: warn_contacts
  use listing_contact, only: list_contact
  use material_type, only: material_t
  use mesh, only: block_t, is_rigid
  use model, only: model_t, material_set_t
  implicit none
  private
  public :: list_model, warn_loose, warn_unread

contains

  !> Sizes, element types and laws with their sources.
  subroutine list_model(model)
    type(model_t), intent(in) :: model
    integer :: b, m

    call log_line('title     '//model%title)
    call log_line('nodes     '//to_text(count(model%mesh%used))//' in use, ' &
                  //to_text(count(model%mesh%is_control))//' of them control points')
    call log_line('dofs      '//to_text(model%ndof)//', equations '//to_text(model%neq))
    do b = 1, size(model%mesh%body)
      associate (body => model%mesh%body(b))
        if (allocated(body%note)) call log_line("mesh      '"//body%name//"': "//body%note)
      end associate
    end do
    do b = 1, size(model%mesh%block)
      call list_block(model, model%mesh%block(b))
    end do
    do m = 1, size(model%material)
      call list_material(model%material(m))
    end do
    do m = 1, size(model%contact)
      call list_contact(model%contact(m))
    end do
    if (any(is_rigid(model%mesh%block)) .and. size(model%contact) == 0) then
      call log_line('rigid     the deck has no CONTact: rigid patches move nothing but what is ' &
                    //'tied')
    end if
    call warn_contacts(model)
    call warn_loose(model)
    call warn_unread(model)
    call log_line('')
  end subroutine list_model

  !> Displacements that act nowhere.
  subroutine warn_loose(model)
    type(model_t), intent(in) :: model
    integer :: i

    if (.not. allocated(model%bc%loose)) return
    do i = 1, size(model%bc%loose)
      call warn('a displacement is prescribed where the node is free: it has no effect there', &
                model%bc%loose(i), hint='restrain it: BOUN, EBOU, CBOU or FIX')
    end do
  end subroutine warn_loose

  !> Tables of constraints that nobody read.
  subroutine warn_unread(model)
    type(model_t), intent(in) :: model
    integer :: i

    if (.not. allocated(model%unread)) return
    do i = 1, size(model%unread)
      call warn(model%unread(i)%text, model%unread(i)%place, &
                'give CONStraint in this block: without it nodes that hang are free')
    end do
  end subroutine warn_unread

  subroutine list_block(model, block)
    type(model_t), intent(in) :: model
    type(block_t), intent(in) :: block
    character(:), allocatable :: text

    text = 'elements  '//to_text(block%nelem)//' '//trim(block%name)//where_of(model, block%body)
    if (.not. is_rigid(block)) text = text//', '//to_text(block%nen)//' nodes, ' &
                                      //to_text(block%rule%nq)//' points, material ' &
                                      //to_text(model%material(block%material)%number)
    call log_line(text)
    call log_line('          '//trim(block%row%source))
  end subroutine list_block

  function where_of(model, body) result(text)
    type(model_t), intent(in) :: model
    integer, intent(in) :: body
    character(:), allocatable :: text

    text = ''
    if (body > 0) text = " of '"//model%mesh%body(body)%name//"'"
  end function where_of

  subroutine list_material(material)
    type(material_set_t), intent(in) :: material
    character(:), allocatable :: values
    integer :: i

    values = ''
    do i = 1, material%row%nprop
      values = values//' '//to_text(material%prop(i))
    end do
    call log_line('material  '//to_text(material%number)//' '//trim(material%row%name)//':'//values)
    call log_line('          '//trim(material%row%source))
  end subroutine list_material

end module listing
