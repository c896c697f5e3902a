!> Contacts that have not closed in any step of a run: their smallest gap, and a note at the end.
!!
!! The other body may be an obstacle that nothing is meant to reach, so a note is issued instead of
!! a warning, unless corners of elements penetrate while no integration point does. A contact with
!! bonds is left out, because its faces are meant to separate.
module contact_missed
  use base_kinds, only: wp
  use base_log, only: note, warn
  use base_text, only: position_text, to_text
  use contact_nearness, only: start_t, look_at_start
  use contact_pair, only: contact_t, contact_state_t
  use contact_resultant, only: resultant_t, side_resultant
  use model, only: model_t, state_t
  implicit none
  private
  public :: follow_gaps, note_missed

  !> Penetrations of a corner, relative to the smaller of the element size and the thickness. A
  !! penetration below NOTHING is only rounding error; one above VISIBLE causes a warning.
  real(wp), parameter :: NOTHING = 1.0e-9_wp, VISIBLE = 1.0e-3_wp

contains

  !> After a step is accepted, find out whether a contact has closed. If not, keep the smallest gap
  !! so far. The gap in the reference configuration is included as that of step 0.
  subroutine follow_gaps(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    type(resultant_t) :: side
    integer :: c, k

    do c = 1, size(model%contact)
      associate (contact => model%contact(c), now => state%contact(c))
        if (now%touched .or. contact%cohesive%given) cycle
        do k = 1, 2
          call side_resultant(model, state, c, k, [0.0_wp, 0.0_wp, 0.0_wp], side)
          now%touched = now%touched .or. side%nclosed > 0 .or. side%area > 0.0_wp
        end do
        if (now%touched) cycle
        if (.not. now%nearest < huge(1.0_wp)) call keep_gap(contact, model%mesh%xr, 0, now)
        call keep_gap(contact, model%mesh%xr + state%u, state%step, now)
      end associate
    end do
  end subroutine follow_gaps

  !> Keep the smallest gap at the positions x if it is smaller than the earlier ones, and the
  !! penetration of a rigid side that lies between the integration points of the other side.
  subroutine keep_gap(contact, x, step, now)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)      !! (3, nnode) [L]
    integer, intent(in) :: step
    type(contact_state_t), intent(inout) :: now
    type(start_t) :: start

    call look_at_start(contact, x, start)
    if (start%unseen .and. any(start%width > 0.0_wp)) then
      now%deepest = max(now%deepest, start%deepest/minval(start%width, start%width > 0.0_wp))
    end if
    if (.not. start%gap < now%nearest) return
    now%nearest = start%gap
    now%x_nearest = start%x_gap
    now%nearest_step = step
  end subroutine keep_gap

  !> At the end of a run, name the contacts that have not closed in any step. PENEtration, unlike
  !! the gap, includes corners of elements.
  subroutine note_missed(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    character(:), allocatable :: text, whose
    integer :: c

    if (state%step == 0) return
    do c = 1, size(model%contact)
      associate (contact => model%contact(c), now => state%contact(c))
        if (now%touched .or. contact%cohesive%given) cycle
        text = "contact '"//contact%name//"' has not closed in any step: "
        whose = ''
        if (now%deepest > NOTHING) whose = ' of an integration point'
        if (now%nearest < huge(1.0_wp)) then
          text = text//'the smallest gap'//whose//' was '//to_text(now%nearest, 3)//' at ' &
                 //position_text(now%x_nearest)
          if (now%nearest_step == 0) then
            text = text//', at the start'
          else
            text = text//', in step '//to_text(now%nearest_step)
          end if
        else
          text = text//'no point of either side was ever opposite the other side and close to it'
        end if
        if (now%deepest > NOTHING) then
          text = text//'; corners of elements penetrate by up to '//to_text(100*now%deepest, 3) &
                 //' % of the size of an element'
        end if
        if (now%deepest > VISIBLE) then
          call warn(text, contact%place, 'contact acts only at integration points: use smaller ' &
                    //'elements or more integration points')
        else
          call note(text)
        end if
      end associate
    end do
  end subroutine note_missed

end module contact_missed
