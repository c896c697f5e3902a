!> The summary of the model in the log: its sizes and the formulations in use.
module listing
  use base_log, only: log_line, warn
  use base_text, only: to_text
  use boundary, only: LOOSE_ADDED, LOOSE_MOVED
  use contact_start, only: warn_contacts
  use listing_contact, only: list_contact
  use mesh, only: is_rigid
  use model, only: model_t
  use rigid_modes, only: free_body_t, find_free_bodies, motion_text
  implicit none
  private
  public :: list_model, list_free_bodies, warn_loose, warn_unread

  integer, parameter :: MOST = 10      !! largest number of free bodies that are listed

contains

  !> List sizes, element types and laws with their sources, and contacts; then issue the warnings
  !! about the model.
  subroutine list_model(model)
    type(model_t), intent(in) :: model
    character(:), allocatable :: text
    integer :: b, i, m

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
      associate (block => model%mesh%block(b))
        text = 'elements  '//to_text(block%nelem)//' '//trim(block%name)
        if (block%body > 0) text = text//" of '"//model%mesh%body(block%body)%name//"'"
        if (.not. is_rigid(block)) text = text//', '//to_text(block%nen)//' nodes, ' &
                                          //to_text(block%rule%nq)//' points, material ' &
                                          //to_text(model%material(block%material)%number)
        call log_line(text)
        call log_line('          '//trim(block%row%source))
      end associate
    end do
    do m = 1, size(model%material)
      associate (material => model%material(m))
        text = 'material  '//to_text(material%number)//' '//trim(material%row%name)//':'
        do i = 1, material%row%nprop
          text = text//' '//to_text(material%prop(i))
        end do
        call log_line(text)
        call log_line('          '//trim(material%row%source))
      end associate
    end do
    do m = 1, size(model%contact)
      call list_contact(model%contact(m))
    end do
    if (any(is_rigid(model%mesh%block)) .and. size(model%contact) == 0) then
      call log_line('rigid     the deck has no CONTact, so rigid bodies move only the nodes ' &
                    //'tied to them')
    end if
    call list_free_bodies(model)
    call warn_contacts(model)
    call warn_loose(model)
    call warn_unread(model)
    call log_line('')
  end subroutine list_model

  !> List the bodies without sufficient supports, and their motions. If `warns` is true, warn about
  !! the bodies that contact cannot hold either.
  subroutine list_free_bodies(model, warns)
    type(model_t), intent(in) :: model
    logical, intent(in), optional :: warns
    type(free_body_t), allocatable :: body(:)
    character(:), allocatable :: motions
    logical :: asked
    integer :: b

    asked = .false.
    if (present(warns)) asked = warns
    call find_free_bodies(model, model%mesh%xr, body)
    if (size(body) > MOST) call log_line('free      '//to_text(size(body)) &
                                         //' bodies, of which '//to_text(MOST)//' are listed')
    do b = 1, min(size(body), MOST)
      motions = motion_text(body(b)%motion(:, :body(b)%nmotion))
      if (body(b)%in_contact) then
        call log_line('free      '//body(b)%name//' can '//motions//' unless contact holds it')
      else if (asked) then
        call warn('nothing holds '//body(b)%name//', which can '//motions, &
                  hint='support it: FIX or MOVE for patches; BOUN, EBOU or CBOU for nodes')
      else
        call log_line('free      '//body(b)%name//' can '//motions//': nothing holds it')
      end if
    end do
  end subroutine list_free_bodies

  !> Warn about displacements prescribed at dofs without a restraint, where they have no effect, or
  !! at dofs that MOVE moves.
  subroutine warn_loose(model)
    type(model_t), intent(in) :: model
    integer :: i

    if (.not. allocated(model%bc%loose)) return
    do i = 1, size(model%bc%loose)
      select case (model%bc%loose_kind(i))
      case (LOOSE_ADDED)
        call warn('a displacement is prescribed at a dof that MOVE prescribes too, and the two ' &
                  //'are added', model%bc%loose(i), hint='remove this record or the MOVE, so ' &
                  //'that one of them prescribes the whole motion')
      case (LOOSE_MOVED)
        call warn('a displacement is prescribed at a dof that MOVE already prescribes, where it ' &
                  //'has no effect', model%bc%loose(i), hint='remove this record, because MOVE ' &
                  //'prescribes the whole motion, or replace the MOVE by FIX')
      case default
        call warn('a displacement is prescribed at a free dof, where it has no effect', &
                  model%bc%loose(i), hint='restrain it: BOUN, EBOU, CBOU or FIX')
      end select
    end do
  end subroutine warn_loose

  !> Warn about constraint tables that exist next to files of the deck and were not read.
  subroutine warn_unread(model)
    type(model_t), intent(in) :: model
    integer :: i

    if (.not. allocated(model%unread)) return
    do i = 1, size(model%unread)
      call warn(model%unread(i)%text, model%unread(i)%place, &
                'add CONStraint to this block; without it, the hanging nodes are free')
    end do
  end subroutine warn_unread

end module listing
