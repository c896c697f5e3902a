!> Warnings, from the steps that have been closed, about input that is probably not intended.
module command_watch
  use base_error, only: place_t
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: position_text, quoted, to_text
  use basis_type, only: basis_t
  use boundary, only: place_of_number
  use command_turns, only: watch_turns, watch_turned
  use command_type, only: run_t
  use contact_assembly, only: friction_acts
  use contact_patch, only: warn_small_patches
  use dynamics_type, only: BACKWARD_EULER
  use energy_growth, only: warn_growth
  use failure_text, only: element_name
  use force_rounding, only: warn_rounding
  use inverted_corners, only: inverted_t, find_inverted_corners
  use load_curve, only: load_factor, table_factor
  use mesh, only: block_t, is_rigid
  use model_basis, only: tabulate_points
  use table_use, only: watch_tables, watch_tables_end
  implicit none
  private
  public :: watch_step, watch_end

  real(wp), parameter :: SMALL = 0.1_wp !! largest displacement gradient of small strains

contains

  !> Examine the step that was closed; a warning is not repeated in later steps.
  subroutine watch_step(run)
    type(run_t), intent(inout) :: run
    integer :: c

    associate (contact => run%model%contact)
      if (.not. allocated(run%plan%rubbed)) then
        allocate (run%plan%rubbed(size(contact)), source=.false.)
      end if
      do c = 1, size(contact)
        if (friction_acts(contact(c), run%state)) run%plan%rubbed(c) = .true.
      end do
    end associate
    if (.not. run%plan%turn_warned) call watch_turns(run)
    if (.not. run%plan%strain_warned) call watch_turned(run)
    if (.not. run%plan%strain_warned) call watch_strains(run)
    if (run%state%step == 1) call watch_start(run)
    if (.not. run%plan%inverted_warned) call watch_corners(run)
    call watch_tables(run)
  end subroutine watch_step

  !> After the first step of a motion computed by NEWMark or HHT: warn about prescribed
  !! displacements that are not 0 at its start, so that their velocity is infinite.
  subroutine watch_start(run)
    type(run_t), intent(in) :: run
    real(wp) :: start(size(run%state%table))
    logical :: heavy(run%model%mesh%nnode) ! nodes of bodies with a density
    type(place_t) :: place
    character(:), allocatable :: word
    integer :: i, k

    associate (state => run%state, bc => run%model%bc)
      if (.not. state%dynamics%on .or. state%dynamics%method == BACKWARD_EULER) return
      start = [(table_factor(state%table(k), state%time - state%dt), k=1, size(state%table))]
      heavy = .false.
      do i = 1, size(run%model%mesh%block)
        associate (block => run%model%mesh%block(i))
          if (is_rigid(block)) cycle
          if (.not. run%model%material(block%material)%density > 0.0_wp) cycle
          do k = 1, block%nelem
            heavy(block%conn(:, k)) = .true.
          end do
        end associate
      end do
      do i = 1, size(bc%motion)
        associate (motion => bc%motion(i))
          if (.not. (motion%rotates .or. any(abs(motion%vector) > 0.0_wp))) cycle
          if (.not. (jumps(motion%table) .and. any(heavy(motion%node)))) cycle
          word = 'MOVE'
          place = motion%place
        end associate
      end do
      if (.not. allocated(word)) then
        nodes: do i = 1, size(bc%table, 2)
          do k = 1, 3
            if (.not. (abs(bc%value(k, i)) > 0.0_wp .and. bc%fixed(k, i) /= 0)) cycle
            if (.not. (heavy(i) .and. jumps(bc%table(k, i)))) cycle
            word = 'DISPlacement'
            call place_of_number(bc, bc%table(k, i), place)
            exit nodes
          end do
        end do nodes
      end if
      if (.not. allocated(word)) return
      call warn('the motion of '//word//' begins with a jump: its factor is not 0 at the start ' &
                //'of the first step, so that velocities and forces depend on DT however small ' &
                //'it is', place, 'give it a load table that begins with the factor 0: PROP,,k ' &
                //'with pairs t p, such as 0 0 and the end of the motion; a body that is to rest ' &
                //'there needs no TRANsient before')
    end associate

  contains

    pure logical function jumps(table)
      integer, intent(in) :: table

      jumps = size(start) == 0
      if (.not. jumps) jumps = abs(load_factor(start, table)) > 0.0_wp
    end function jumps

  end subroutine watch_start

  !> Warn if a material for small strains is strongly stretched or rotated.
  subroutine watch_strains(run)
    type(run_t), intent(inout) :: run
    real(wp) :: largest
    integer :: b

    do b = 1, size(run%model%mesh%block)
      associate (block => run%model%mesh%block(b))
        if (is_rigid(block)) cycle
        if (run%model%material(block%material)%row%finite) cycle
        largest = largest_gradient(block, run%model%mesh%xr, run%state%u)
        if (largest <= SMALL) cycle
        call warn('displacement gradients reach '//to_text(100*largest, 3)//' % in step ' &
                  //to_text(run%state%step)//', but material ' &
                  //to_text(run%model%material(block%material)%number) &
                  //' is for small strains (SMALl)', &
                  run%model%material(block%material)%place, 'SMALl is valid for strains and ' &
                  //'rotations of a few per cent; beyond that, use NEOHook with FINIte')
        run%plan%strain_warned = .true.
        return
      end associate
    end do
  end subroutine watch_strains

  !> Largest ratio of the differences of displacements and of positions within an element of a
  !! block. Elements of splines are examined at points of the body, because their control points
  !! may move much farther than the body.
  function largest_gradient(block, xr, u) result(largest)
    type(block_t), intent(in) :: block
    real(wp), intent(in) :: xr(:, :), u(:, :) !! (3, nnode) positions and displacements [L]
    real(wp) :: largest
    integer, parameter :: NPOINT = 27         ! 3 in each direction
    real(wp), parameter :: SAME = 1.0e-9_wp   ! relative distance of points at one place
    type(basis_t) :: basis
    real(wp), allocatable :: dx(:, :), du(:, :)
    real(wp) :: xi(3, NPOINT)
    integer :: class, e, i

    do i = 1, NPOINT
      xi(:, i) = mod((i - 1)/[1, 3, 9], 3) - 1.0_wp
    end do
    largest = 0.0_wp
    class = 0
    do e = 1, block%nelem
      dx = xr(:, block%conn(:, e))
      du = u(:, block%conn(:, e))
      if (block%row%spline) then
        if (block%ibasis(e) /= class) then
          class = block%ibasis(e)
          call tabulate_points(block, e, xi, spread(1.0_wp, 1, NPOINT), basis)
        end if
        dx = matmul(dx, basis%shp)
        du = matmul(du, basis%shp)
      end if
      dx = dx - spread(dx(:, 1), 2, size(dx, 2))
      du = du - spread(du(:, 1), 2, size(du, 2))
      do i = 2, size(dx, 2)
        if (norm2(dx(:, i)) <= SAME*maxval(abs(dx))) cycle ! of a collapsed element
        largest = max(largest, norm2(du(:, i))/norm2(dx(:, i)))
      end do
    end do
  end function largest_gradient

  !> Warn about elements that are inside out at a corner.
  subroutine watch_corners(run)
    type(run_t), intent(inout) :: run
    type(inverted_t) :: found
    type(place_t) :: place
    character(:), allocatable :: text

    call find_inverted_corners(run%model, run%state%u, found)
    if (found%nelem == 0) return
    associate (mesh => run%model%mesh, block => run%model%mesh%block(found%block))
      text = element_name(run%model, found%block, found%elem)//' is inside out at its ' &
             //'corner, at '//position_text(found%x)//' before the deformation, in step ' &
             //to_text(run%state%step)//', at time '//to_text(run%state%time)
      if (found%nelem > 1) text = text//' (the worst of '//to_text(found%nelem)//' elements)'
      place = run%model%material(block%material)%place
      if (block%body > 0) place = mesh%body(block%body)%place
    end associate
    call warn(text//': the determinant of the deformation gradient is '//to_text(found%j, 3) &
              //' there, although it is positive at all integration points, and results near ' &
              //'this corner have no meaning', place, 'distribute a load or a prescribed motion ' &
              //'that acts at single nodes over a face; otherwise use smaller elements there, or ' &
              //'smaller steps before this time')
    run%plan%inverted_warned = .true.
  end subroutine watch_corners

  !> Warn if the interval of OUTPut or TPLOt is longer than the run, so that nothing was written.
  subroutine warn_intervals(run)
    type(run_t), intent(in) :: run
    integer :: i, kept

    if (run%state%step == 0) return
    kept = 0
    if (allocated(run%files%kept)) kept = run%files%kept
    if (run%plan%every > 0 .and. run%files%fields_step < 0 .and. &
        run%state%step/max(1, run%plan%every)*run%plan%every <= kept) then
      call warn('OUTPut wrote no fields: no step of this run has a number that is a multiple of ' &
                //to_text(run%plan%every), hint='put a PLOT after the loop, or give OUTPut a ' &
                //'smaller number')
    end if
    if (.not. allocated(run%files%last_row)) return
    do i = 1, size(run%model%curve)
      if (run%model%curve(i)%name /= 'tplot' .or. allocated(run%files%last_row(i)%value)) cycle
      call warn('TPLOt wrote no row: no step of this run has a number that is a multiple of ' &
                //to_text(run%plan%tplot_every), run%model%curve(i)%place, &
                'give TPLOt a smaller number')
    end do
  end subroutine warn_intervals

  !> At the end of a run, warn about loads and friction that never acted, and about results that the
  !! whole run has shown to be doubtful.
  subroutine watch_end(run)
    type(run_t), intent(in) :: run
    integer :: c

    call watch_tables_end(run)
    call warn_intervals(run)
    call warn_growth(run%state)
    call warn_rounding(run%step)
    call warn_small_patches(run%model, run%state, run%step%total%load)
    if (.not. allocated(run%plan%rubbed)) return ! no step was closed
    do c = 1, size(run%model%contact)
      associate (contact => run%model%contact(c))
        if (.not. contact%friction%given .or. run%plan%rubbed(c)) cycle
        call warn('contact '//quoted(contact%name)//': friction never acts, because the last ' &
                  //'step starts at time '//to_text(run%state%time - run%state%dt)//', before ' &
                  //'AFTEr '//to_text(contact%after), contact%place, &
                  'friction acts in steps that start at the time of AFTEr or later')
      end associate
    end do
  end subroutine watch_end

end module command_watch
