!> Reports on bodies that contact does not hold, in the log and on the screen: where they were
!! moved, and the motions that only anchors resist.
module stabilisation_report
  use anchors, only: anchors_t, anchor_force, find_load
  use base_kinds, only: wp
  use base_log, only: note, warn
  use base_text, only: to_text
  use contact_assembly, only: friction_acts
  use model, only: model_t, state_t
  use rigid_modes, only: motion_text
  use stabilisation, only: stabilisation_t
  implicit none
  private
  public :: report_stabilisation, lost_text, direction_text

  real(wp), parameter :: ROUGH = 0.2_wp    !! smaller parts of a motion are not named
  real(wp), parameter :: ALONG = 1.0e-6_wp !! smaller components of a unit vector count as zero
  real(wp), parameter :: MUCH = 1.0e-4_wp  !! share of anchors in all loads, or in all work, that
  !! calls for another warning
  real(wp), parameter :: TENFOLD = 10.0_wp !! growth of this share that calls for another warning

contains

  !> Report what was done in an accepted step.
  subroutine report_stabilisation(hold, model, state, f_ext, anchors, scale)
    type(stabilisation_t), intent(inout) :: hold
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: f_ext(:, :)  !! (3, nnode) loads [F]
    type(anchors_t), intent(in) :: anchors
    real(wp), intent(in) :: scale        !! sum of all loads [F]
    real(wp), allocatable :: q(:, :), force(:, :), du(:, :)
    character(:), allocatable :: start, names, shares, more
    real(wp) :: motion(6, size(hold%body)), load, share
    logical :: rubs, waits               ! friction acts on such a body; it acts only later
    logical :: acts(size(model%contact)) ! friction acts in this contact
    integer :: b

    if (.not. hold%used) return
    start = 'step '//to_text(state%step)//': '
    do b = 1, size(hold%body)
      if (hold%moves == 0 .or. .not. norm2(hold%shift(:, b)) > 0.0_wp) cycle
      call note(start//hold%body(b)%name//' was moved by '//to_text(norm2(hold%shift(:, b)), 3) &
                //' along '//direction_text(hold%shift(:, b))//' until contact held it')
    end do
    if (.not. allocated(anchors%dv)) return
    allocate (force(3, model%mesh%nnode), source=0.0_wp)
    allocate (du, source=state%u - state%u_step)
    call anchor_force(anchors, du, force)
    hold%energy = hold%energy + 0.5_wp*abs(sum(force*du))
    force = f_ext
    where (model%eq == 0) force = force + state%reaction
    hold%work = hold%work + 0.5_wp*sum(abs(force*du))
    share = 0.0_wp
    if (hold%work > 0.0_wp) share = hold%energy/hold%work
    call find_load(anchors, hold%body, model%eq, model%mesh%xr + state%u, du, motion, load)
    if (scale > 0.0_wp) load = load/scale
    if (hold%warned .and. max(share, load) <= max(MUCH, TENFOLD*hold%warned_share)) return
    hold%warned = .true.
    hold%warned_share = max(share, load)
    names = ''
    rubs = .false.
    waits = .false.
    acts = [(friction_acts(model%contact(b), state), b=1, size(model%contact))]
    do b = 1, size(hold%body)
      call span_of(anchors%motion, b, q)
      if (size(q, 2) == 0) cycle
      if (len(names) > 0) names = names//'; '
      names = names//hold%body(b)%name//' can '//motion_text(q, ROUGH)
      rubs = rubs .or. is_on_body(model, acts, hold%body(b)%node)
      waits = waits .or. is_on_body(model, model%contact%friction%given, hold%body(b)%node)
    end do
    shares = '; stabilising springs prevent this and take '//percent(load)//' of the loads and ' &
             //percent(share)//' of the work'
    if (rubs) then
      call warn(start//'contact and friction offer no further resistance to some motions: '//names &
                //shares, hint='if all points slide, friction has reached its limit: support the ' &
                //'bodies against these motions, or try smaller steps, in which some may stick')
    else
      more = 'add friction'
      if (waits) more = 'let friction act earlier (AFTEr)'
      call warn(start//'contact does not prevent motions along which no load acts: '//names &
                //shares, hint='support the bodies against these motions, or '//more)
    end if
  end subroutine report_stabilisation

  !> Does a body take part in one of the marked contacts?
  pure logical function is_on_body(model, marked, node)
    type(model_t), intent(in) :: model
    logical, intent(in) :: marked(:) !! (ncontact)
    integer, intent(in) :: node(:) !! nodes of the body
    logical :: inside(model%mesh%nnode)
    integer :: c, k

    inside = .false.
    inside(node) = .true.
    is_on_body = .false.
    do c = 1, size(model%contact)
      if (.not. marked(c)) cycle
      do k = 1, 2
        is_on_body = is_on_body .or. any(inside(model%contact(c)%side(k)%node))
      end do
    end do
  end function is_on_body

  !> A share in per cent; a share that is due to rounding is shown as less than 1e-6 %.
  function percent(share) result(text)
    real(wp), intent(in) :: share
    character(:), allocatable :: text

    text = 'less than 1e-6 %'
    if (share >= 1.0e-8_wp) text = to_text(100*share, 2)//' %'
  end function percent

  !> Orthonormal basis of those motions in which body b takes part.
  subroutine span_of(motion, b, basis)
    real(wp), intent(in) :: motion(:, :, :) !! (6, body, m)
    integer, intent(in) :: b
    real(wp), allocatable, intent(out) :: basis(:, :) !! (6, n)
    real(wp) :: d(6), part
    integer :: i, j, pass

    allocate (basis(6, 0))
    do i = 1, size(motion, 3)
      part = norm2(motion(:, b, i))/norm2(motion(:, :, i))
      if (.not. part > ROUGH) cycle
      d = motion(:, b, i)/norm2(motion(:, b, i))
      do pass = 1, 2
        do j = 1, size(basis, 2)
          d = d - dot_product(basis(:, j), d)*basis(:, j)
        end do
      end do
      if (.not. norm2(d) > ROUGH) cycle
      basis = reshape([basis, d/norm2(d)], [6, size(basis, 2) + 1])
    end do
  end subroutine span_of

  !> The reason why a step fails if a body is lost or does not come to rest.
  function lost_text(hold) result(text)
    type(stabilisation_t), intent(in) :: hold
    character(:), allocatable :: text
    integer :: b

    b = maxloc(norm2(hold%shift, 1), 1)
    text = hold%body(b)%name//' moves under its loads along ' &
           //direction_text(hold%shift(:, b))//' by '//to_text(norm2(hold%shift(:, b)), 3) &
           //', and contact does not stop it'
  end function lost_text

  !> Direction of a vector as text: an axis such as -z, or else the unit vector.
  function direction_text(v) result(text)
    real(wp), intent(in) :: v(3)
    character(:), allocatable :: text
    real(wp) :: d(3)
    integer :: i

    d = 0.0_wp
    if (norm2(v) > 0.0_wp) d = v/norm2(v)
    i = maxloc(abs(d), 1)
    if (abs(d(i)) > 1.0_wp - ALONG) then
      text = trim(merge('-', ' ', d(i) < 0.0_wp))//'xyz' (i:i)
    else
      where (abs(d) < ALONG) d = 0.0_wp
      text = '('//to_text(d(1), 3)//', '//to_text(d(2), 3)//', '//to_text(d(3), 3)//')'
    end if
  end function direction_text

end module stabilisation_report
