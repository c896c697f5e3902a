!> Times the closest point of a surface: microseconds a projection on one core, from the foot of the
!! last iteration and with a search, and the update of a surface that has moved. Results are summed
!! so that nothing can be left out.
program bench_projection
  use base_error, only: error_t
  use base_kinds, only: wp, i8
  use projection_type, only: foot_t, shape_t
  use contact_pair, only: surface_t
  use projection, only: project
  use projection_search, only: grid_t, update_grid
  use surface_geometry, only: update_shape
  use contact_surface, only: build_surface
  use mesh, only: mesh_t
  use patch_body, only: build_body
  use patch_spec, only: patch_spec_t, GEO_BOX
  implicit none

  !> The best of many short samples: what others do on the machine must not count.
  integer, parameter :: SAMPLES = 100, NPOINT = 5000, SIDE = 40
  real(wp) :: check

  check = 0.0_wp
  print '(a)', ' projection, one thread [us]; started a hundredth, a tenth of an element away, from the'
  print '(a)', ' grid; update of shape and grid, for each element'
  call time_surface('Q1', 1)
  call time_surface('Q2', 1)
  call time_surface('IGA', 2)
  call time_surface('IGA', 3)
  print '(a, es10.2)', ' checksum', check

contains

  !> A wavy surface of one type, and points near it.
  subroutine time_surface(type, degree)
    character(*), intent(in) :: type
    integer, intent(in) :: degree
    type(patch_spec_t) :: spec
    type(mesh_t) :: mesh
    type(surface_t) :: surface
    type(error_t), allocatable :: error

    spec%name = 'box'
    spec%geometry = GEO_BOX
    spec%length = 1.0_wp
    spec%nelem = [SIDE, SIDE, 1]
    spec%type = type
    spec%degree = degree
    spec%material = 1
    call build_body(spec, mesh, error)
    if (allocated(error)) error stop 'no body'
    associate (face => mesh%body(1)%face(6), x => mesh%xr)
      x(3, :) = x(3, :) + 0.03_wp*sin(7.0_wp*x(1, :))*cos(5.0_wp*x(2, :))
      call build_surface(mesh, face%block, face%elem, face%side, 'box 3+', surface, error)
    end associate
    if (allocated(error)) error stop 'no surface'
    call time_points(trim(type)//' degree '//achar(48 + surface%basis(1)%degree(1)), mesh%xr, surface)
  end subroutine time_surface

  subroutine time_points(name, xr, surface)
    character(*), intent(in) :: name
    real(wp), intent(in) :: xr(:, :)
    type(surface_t), intent(in) :: surface
    type(shape_t) :: shape
    type(grid_t) :: grid
    type(foot_t), allocatable :: foot(:), start(:)
    real(wp), allocatable :: x(:, :)
    real(wp) :: t(4)
    integer(i8) :: from
    integer :: sample

    allocate (foot(NPOINT), start(NPOINT), x(3, NPOINT))
    t = huge(t)
    call random_number(x)
    x(:2, :) = 0.05_wp + 0.9_wp*x(:2, :)
    x(3, :) = 1.0_wp + 0.02_wp*(x(3, :) - 0.5_wp) &
      + 0.03_wp*sin(7.0_wp*x(1, :))*cos(5.0_wp*x(2, :))
    do sample = 1, SAMPLES
      from = clock()
      call update_shape(surface, xr, shape)
      call update_grid(surface, shape, grid)
      t(4) = min(t(4), 1.0e-3_wp*real(clock() - from, wp)/surface%nelem)
      foot%elem = 0
      call time_project(surface, shape, grid, x, foot, t(3))
      start = foot
      call time_project(surface, shape, grid, x + 0.01_wp/SIDE, foot, t(1))
      foot = start
      call time_project(surface, shape, grid, x + 0.1_wp/SIDE, foot, t(2))
    end do
    print '(1x, a, t14, 4f12.3)', name, t
  end subroutine time_points

  subroutine time_project(surface, shape, grid, x, foot, t)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(:, :)
    type(foot_t), intent(inout) :: foot(:)
    real(wp), intent(inout) :: t    !! the least so far
    integer(i8) :: from
    integer :: i

    from = clock()
    do i = 1, size(foot)
      call project(surface, shape, grid, x(:, i), foot(i), 0.1_wp)
    end do
    t = min(t, 1.0e-3_wp*real(clock() - from, wp)/size(foot))
    check = check + sum(foot%gap)
  end subroutine time_project

  !> Nanoseconds.
  function clock() result(t)
    integer(i8) :: t, rate

    call system_clock(t, rate)
    t = t*(1000000000_i8/rate)
  end function clock

end program bench_projection
