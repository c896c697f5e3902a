!> Steps in which a body that lay flat comes to stand on an edge.
!!
!! A body that slides may have a second equilibrium, in which its front face, and not its base,
!! bears on the ground that has been heaped up in front of it. The force along the surface is then
!! not limited by friction. A step that is long enough may find this state, whereas shorter steps
!! follow the body as it slides. Such a state is recognised by the part of the force of a contact
!! that acts between faces which are not opposite each other: it is zero while the body lies flat,
!! and appears suddenly. In a model whose body comes to bear on an edge gradually, it increases
!! little in a short step.
!!
!! Steps with inertia are not examined: in them, bodies may fall on their edges.
module edge_contact
  use assembly, only: assembler_t
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use contact_history, only: had_touched
  use contact_oblique, only: oblique_t, find_oblique, oblique_share, exceeds_friction
  use model, only: model_t, state_t
  implicit none
  private
  public :: find_edge_contact, edge_text, keep_edge_contact

  !> Increase of the part of the force, within a step, that counts as sudden.
  real(wp), parameter :: SUDDEN = 0.02_wp

contains

  !> Find the part of the force that acts between faces which are not opposite each other, for each
  !! contact, and the first contact in which it has appeared suddenly in the current step, which is
  !! not accepted yet.
  subroutine find_edge_contact(asm, model, state, share, found)
    type(assembler_t), intent(in) :: asm
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), allocatable, intent(out) :: share(:) !! (ncontact)
    integer, intent(out) :: found                  !! number of the contact; 0: there is none
    type(oblique_t) :: sums
    integer :: c

    allocate (share(size(model%contact)), source=0.0_wp)
    found = 0
    if (state%dynamics%on) return
    do c = size(share), 1, -1
      associate (now => state%contact(c))
        sums = find_oblique(model%contact(c), asm%contact(c), now%side)
        share(c) = oblique_share(sums)
        if (now%oblique > SUDDEN .or. share(c) - now%oblique <= SUDDEN) cycle
        if (had_touched(now) .and. exceeds_friction(model%contact(c), sums)) found = c
      end associate
    end do
  end subroutine find_edge_contact

  !> What has been found in a contact, as the reason of a cut-back.
  function edge_text(model, c, share) result(text)
    type(model_t), intent(in) :: model
    integer, intent(in) :: c
    real(wp), intent(in) :: share                  !! of contact c
    character(:), allocatable :: text

    text = 'in contact '//model%contact(c)%name//', an edge suddenly carries ' &
           //to_text(100*share, 2)//' % of the force'
  end function edge_text

  !> When a step is accepted, keep the parts of the forces, and warn once if one of them has
  !! appeared suddenly.
  subroutine keep_edge_contact(model, state, share, found)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), intent(in) :: share(:)               !! (ncontact)
    integer, intent(in) :: found                   !! see find_edge_contact

    state%contact%oblique = share
    if (found == 0) return
    if (state%contact(found)%oblique_warned) return
    state%contact(found)%oblique_warned = .true.
    call warn("contact '"//model%contact(found)%name//"': in step "//to_text(state%step)//', ' &
              //to_text(100*share(found), 2)//' % of the force suddenly acts between faces that ' &
              //'are not opposite each other: a body may stand on its edge, with a force along ' &
              //'the surface that friction does not limit', model%contact(found)%place, &
              'if the body should slide flat, name only the faces that slide instead of ALL, or ' &
              //'take smaller steps: a smaller DT with AUTO,,dtmin,dtmax')
  end subroutine keep_edge_contact

end module edge_contact
