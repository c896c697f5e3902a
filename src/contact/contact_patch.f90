!> The size of the region in which two faces touch, compared with their elements.
!!
!! Where faces, edges or corners touch in a region much smaller than an element, the pressure is
!! hardly more than a nodal force, and it depends on the mesh. A region counts as small only if two
!! measures agree on every side that deforms:
!!
!! - At most half of the area of every element of the side touches.
!! - The region is narrow. Its width follows from the second moments of the pressure forces about
!!   their centre: it is 4 times the square root of the middle principal moment divided by the total
!!   force. This is 2 b for Hertz's pressure on a strip of width 2 b, and 1.8 a on a circle of
!!   radius a. The smallest moment is that along the normal of a flat region.
!!
!! Several regions far apart and long curved ones are therefore not reported.
module contact_patch
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use contact_history, only: side_positions
  use contact_pair, only: contact_t, contact_state_t, contact_points_t, is_integrated
  use contact_type, only: OPEN
  use lapack, only: dsyev
  use model, only: model_t, state_t
  implicit none
  private
  public :: follow_patch, warn_small_patches

  real(wp), parameter :: LARGEST_SHARE = 0.5_wp !! largest touching fraction of an element
  real(wp), parameter :: SMALL = 0.5_wp       !! width of a small region, relative to an element
  real(wp), parameter :: WEAK = 0.05_wp       !! a smaller fraction of the largest force is ignored
  real(wp), parameter :: NO_FORCE = 1.0e-9_wp !! negligible fraction of the largest load

contains

  !> Measure and store the size of the touching region. Called after a step in which the force is
  !! the largest one so far.
  subroutine follow_patch(contact, x, now)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)           !! (3, nnode) current positions [L]
    type(contact_state_t), intent(inout) :: now
    real(wp) :: size_of_side
    integer :: k

    now%patch = -1.0_wp
    if (contact%cohesive%given .or. contact%self) return
    do k = 1, 2
      if (.not. is_integrated(contact, k)) cycle
      call measure_patch(contact, k, x, now%side(k), size_of_side)
      now%patch = max(now%patch, size_of_side)
    end do
  end subroutine follow_patch

  !> Find the width of the touching region of side k, relative to its elements; negative: no point
  !! touches. If the region covers most of an element, the result is at least 1.
  subroutine measure_patch(contact, k, x, points, width)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    real(wp), intent(in) :: x(:, :)
    type(contact_points_t), intent(in) :: points
    real(wp), intent(out) :: width
    real(wp) :: xp(3, contact%nq), moment(3, 3), principal(3), work(16)
    real(wp) :: near(3), centre(3), force, total, element, area, touching
    integer :: e, i, info, j, q
    logical :: covers

    covers = .false.
    width = -1.0_wp
    total = 0.0_wp
    centre = 0.0_wp
    moment = 0.0_wp
    element = 0.0_wp
    do e = 1, contact%side(k)%nelem
      i = (e - 1)*contact%nq
      if (all(points%state(i + 1:i + contact%nq) == OPEN)) cycle
      call side_positions(contact%side(k), e, x, xp)
      area = 0.0_wp
      touching = 0.0_wp
      do q = 1, contact%nq
        area = area + points%area(i + q)
        if (points%state(i + q) == OPEN) cycle
        ! pressures of control points (MORTar) extend over whole elements
        if (.not. points%pressure(i + q) > contact%control_penalty*points%gap(i + q)) cycle
        touching = touching + points%area(i + q)
        if (.not. total > 0.0_wp) near = xp(:, q)
        xp(:, q) = xp(:, q) - near ! keeps the digits far from the origin
        force = points%pressure(i + q)*points%area(i + q)
        total = total + force
        centre = centre + force*xp(:, q)
        element = element + force*contact%side(k)%width(e)
        do j = 1, 3
          moment(:, j) = moment(:, j) + force*xp(j, q)*xp(:, q)
        end do
      end do
      covers = covers .or. touching > LARGEST_SHARE*area
    end do
    if (.not. total > 0.0_wp) return
    centre = centre/total
    do j = 1, 3
      moment(:, j) = moment(:, j)/total - centre(j)*centre
    end do
    call dsyev('N', 'U', 3, moment, 3, principal, work, size(work), info)
    width = 4.0_wp*sqrt(max(principal(2), 0.0_wp))/(element/total)
    if (covers) width = max(width, 1.0_wp)
  end subroutine measure_patch

  !> At the end of a run, name the contacts whose region was small when their force was largest.
  !! Contacts with small forces are left out, and so are forces that are rounding errors.
  subroutine warn_small_patches(model, state, load)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: load !! largest load or reaction of the run; 0: all are rounding errors
    integer :: c

    do c = 1, size(model%contact)
      associate (contact => model%contact(c), now => state%contact(c))
        if (now%patch < 0.0_wp .or. now%patch >= SMALL) cycle
        if (now%largest_force < WEAK*maxval(state%contact%largest_force)) cycle
        if (.not. now%largest_force > NO_FORCE*load .or. .not. load > 0.0_wp) cycle
        call warn("contact '"//contact%name//"': at its largest force, "// &
                  to_text(now%largest_force, 3)//', the faces touch in a region that is less ' &
                  //'than half an element wide: the pressure depends on the mesh, and so ' &
                  //'does the force needed for a prescribed motion', contact%place, 'use smaller ' &
                  //'elements there: an accurate pressure needs several across the region')
      end associate
    end do
  end subroutine warn_small_patches

end module contact_patch
